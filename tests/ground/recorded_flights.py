"""Flights of the real firmware, recorded as kite-ground does it, and ways to look at what was recorded."""

from pathlib import Path

from ground.logs.reader import MessageLog, read_message_log
from ground.logs.recorder import Recorder
from ground.session import Session
from protocol import dialect


def record(kite, path: Path, gain: float = 2.5) -> MessageLog:
    """Fly for 14 s: change a gain on the way, park, and fly on."""
    with kite.session(print) as session, Recorder(session.connection, path, kite.wall_clock() - kite.clock()):
        session.parameters.fetch_all()
        let_pass(session, 4.0)
        session.parameters.set("INNER_P", gain)
        let_pass(session, 4.0)
        session.commander.set_mode(dialect.KITE_MODE_PARK)
        let_pass(session, 2.0)
        session.commander.set_mode(dialect.KITE_MODE_TRACK)
        let_pass(session, 4.0)
    return read_message_log(path)


def let_pass(session: Session, seconds: float) -> None:
    """Let the session work for so long."""
    session.connection.wait_until(lambda: False, seconds)


def payloads(log: MessageLog, kind: type[dialect.MAVLink_message]) -> list[bytes]:
    """What the vehicle's messages of one kind carried, in the order in which they came."""
    return [entry.frame[10:-2] for entry in log.of(log.vehicle()) if isinstance(entry.message, kind)]
