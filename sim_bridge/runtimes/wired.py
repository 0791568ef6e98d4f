"""Base of all runtimes with a wire: sends a tick's frames, receives the firmware's, sorts them."""

import time

from protocol import dialect
from protocol.messages import KiteState
from sim_bridge.equipment.sensors import Sample
from sim_bridge.errors import FirmwareError
from sim_bridge.links.wire import BridgeCodec, in_datagrams, wire_values
from sim_bridge.runtimes.interface import LEAD_IN_S, Message
from sim_bridge.runtimes.tick_output import TickOutput, clock_us, told_state

SILENCE_S = 20.0  # a suspended process may come back
_REPLIES = frozenset(("PARAM_VALUE", "PARAM_ERROR", "COMMAND_ACK", "STATUSTEXT"))


class WireRuntime:
    """A firmware in lockstep behind datagrams; subclasses say how to `_send` and `_receive` one."""

    name: str = "wire"
    lead_in_s: float = LEAD_IN_S

    def __init__(self) -> None:
        self._codec = BridgeCodec()

    def exchange(self, tick: int, time_s: float, samples: list[Sample], requests: list[Message],
                 datagrams: list[bytes]) -> TickOutput:
        """See Runtime."""
        self._send_inputs(samples, requests, datagrams)
        self._send(self._codec.encode(dialect.MAVLINK_MSG_ID_KITE_TICK, (tick, clock_us(time_s))))
        output = TickOutput()
        deadline = time.monotonic() + SILENCE_S
        while True:
            ended = self._sort(self._receive(deadline, f"in tick {tick}"), time_s, output)
            if ended == tick:
                return output
            if ended is not None:
                raise FirmwareError(f"the firmware ended tick {ended} when it was asked for tick {tick}")

    def _send_inputs(self, samples: list[Sample], requests: list[Message], datagrams: list[bytes]) -> None:
        """Send what the firmware may see in a tick."""
        frames = [self._codec.encode(dialect.MAVLINK_MSG_ID_KITE_SENSORS, sample) for sample in samples]
        frames += [self._codec.encode(message, values) for message, values in requests]
        for datagram in in_datagrams(frames) + datagrams:
            self._send(datagram)

    def _sort(self, data: bytes, time_s: float, output: TickOutput) -> int | None:
        """Add what `data`, of the time `time_s`, holds to `output`; return the number of a tick that it ends."""
        ended = None
        for message in self._codec.decode(data):
            if isinstance(message, dialect.MAVLink_hil_actuator_controls_message):
                steering, *_others = message.controls
                output.steering.append((time_s, steering))
                continue
            if isinstance(message, dialect.MAVLink_kite_tick_end_message):
                ended = message.tick
                continue
            if isinstance(message, dialect.MAVLink_kite_state_message):
                output.state = told_state(KiteState._make(wire_values(message)))
            elif isinstance(message, dialect.MAVLink_heartbeat_message):
                output.mode = message.custom_mode
            elif message.get_type() in _REPLIES:
                output.replies.append((message.get_msgId(), wire_values(message)))
            output.frames.append(bytes(message.get_msgbuf()))
        return ended

    def _send(self, datagram: bytes) -> None:
        raise NotImplementedError

    def _receive(self, deadline: float, when: str) -> bytes:
        """One datagram, by the wall clock's `deadline`; `when` says in an error what was waited for."""
        raise NotImplementedError
