"""A ground station, and a kite that hovers, on the line to an emulated Pico's UART."""

from typing import Any

from protocol import dialect
from tests.emulated_pico.pico import EmulatedPico

ARM, DO_SET_MODE = dialect.MAV_CMD_COMPONENT_ARM_DISARM, dialect.MAV_CMD_DO_SET_MODE
_PERIOD_S = 0.02
_PATIENCE_S = 3.0
_INSTANT_S = 1e-6  # the emulator's steps are instructions


class Station:
    """Sends a sample each period while `kite` is True; `heard` has all that the board said."""

    def __init__(self, pico: EmulatedPico):
        self.kite = False
        self.heard: list[Any] = []
        self._pico = pico
        self._mav = dialect.MAVLink(None, 255, 190)
        self._mav.robust_parsing = True

    def tell(self, *messages: dialect.MAVLink_message) -> None:
        """Send messages."""
        for message in messages:
            self._pico.send(message.pack(self._mav))
            self._mav.seq = (self._mav.seq + 1) % 256

    def run(self, seconds: float) -> str:
        """Let time pass, or until a reset; returns as EmulatedPico.run does."""
        end = self._pico.now + seconds
        why = "time"
        while why == "time" and self._pico.now < end - _INSTANT_S:
            if self.kite:
                self.tell(dialect.MAVLink_kite_sensors_message(
                    round(self._pico.now * 1e6), 0.1, 0.7, 100.0, 0.5, 0.5, 20.0, 50.0, 0.0, 0xFF))
            why = self._pico.run(min(_PERIOD_S, end - self._pico.now))
            self.heard += [message for message in self._mav.parse_buffer(self._pico.take_uart()) or []
                           if message.get_type() != "BAD_DATA"]
        return why

    def ask(self, question: dialect.MAVLink_message, kind: str) -> Any:
        """Send `question`; return the next message of `kind`."""
        self.forget()
        self.tell(question)
        return self.hear(kind)

    def hear(self, kind: str, seconds: float = _PATIENCE_S) -> Any:
        """The first message of `kind` in what was heard, or is within `seconds`."""
        end = self._pico.now + seconds
        while not (found := self.of_kind(kind)):
            assert self._pico.now < end, f"no {kind} within {seconds:g} s; console: {self._pico.printed()}"
            self.run(_PERIOD_S)
        return found[0]

    def forget(self) -> None:
        """Forget what was heard, and what the board has sent meanwhile."""
        self._pico.take_uart()
        self.heard.clear()

    def of_kind(self, kind: str) -> list[Any]:
        """The messages of `kind` heard so far."""
        return [message for message in self.heard if message.get_type() == kind]

    def texts(self) -> list[str]:
        """The STATUSTEXTs heard so far."""
        return [message.text for message in self.of_kind("STATUSTEXT")]

    def command(self, command: int, first: float = 0.0, second: float = 0.0) -> None:
        """Send a command, which must be accepted."""
        question = dialect.MAVLink_command_long_message(1, 1, command, 0, first, second, 0.0, 0.0, 0.0, 0.0, 0.0)
        answer = self.ask(question, "COMMAND_ACK")
        assert (answer.command, answer.result) == (command, dialect.MAV_RESULT_ACCEPTED), answer

    def fly(self, mode: int) -> None:
        """Let the kite hover, arm, and go to `mode`."""
        self.kite = True
        self.run(0.5)
        self.command(ARM, 1.0)
        if mode != dialect.KITE_MODE_PARK:
            self.command(DO_SET_MODE, 1.0, mode)

    def set(self, name: str, value: float) -> None:
        """Set a parameter, which must be accepted."""
        question = dialect.MAVLink_param_set_message(1, 1, name.encode(), value, dialect.MAV_PARAM_TYPE_REAL32)
        answer = self.ask(question, "PARAM_VALUE")
        assert (answer.param_id, answer.param_value) == (name, value)

    def value(self, name: str) -> float:
        """The value that the board has for a parameter."""
        question = dialect.MAVLink_param_request_read_message(1, 1, name.encode(), -1)
        return self.ask(question, "PARAM_VALUE").param_value
