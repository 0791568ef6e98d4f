"""Watches parameters for changes by any ground station."""

from collections.abc import Callable

from ground.link.connection import SILENCE_S, Connection
from ground.link.framing import Message
from ground.parameters.file import format_value
from protocol import dialect


def watch(connection: Connection, values: dict[str, float], every_s: float, duration_s: float,
          told: Callable[[str], None]) -> None:
    """For `duration_s` [s], pass `told` a line for each change of one of `values`, which is updated.

    Changes that the vehicle announces are noticed at once; each parameter is also requested every `every_s` [s], as the
    vehicle need not announce to us what another ground station has set.
    """
    start_s = connection.clock()

    def observe(time_s: float, message: Message, frame: bytes) -> None:
        if not isinstance(message, dialect.MAVLink_param_value_message) or message.param_id not in values:
            return
        name, value = message.param_id, message.param_value
        if value != values[name]:
            told(f"t={time_s - start_s:.1f} {name}: {format_value(values[name])} -> {format_value(value)}")
            values[name] = value

    connection.add_observer(observe)
    try:
        names, turn, silent = list(values), 0, False
        while (left_s := start_s + duration_s - connection.clock()) > 0.0:
            system, component = connection.target
            connection.send(dialect.MAVLink_param_request_read_message(
                system, component, names[turn % len(names)].encode("ascii"), -1))
            turn += 1
            connection.wait_until(lambda: False, min(every_s / len(names), left_s))
            if silent != (connection.silence_s(start_s) >= SILENCE_S):
                silent = not silent
                told("nothing from the kite: the link is down; retrying" if silent
                     else "the kite is heard again")
    finally:
        connection.remove_observer(observe)
