"""What the monitor shows: a table for a terminal, one line for anything else. Degrees here, radians inside."""

import math

from ground.connection import Connection
from ground.vehicle_state import VehicleState
from protocol import dialect

STALE_S = 3.0
_STATUS_NAMES = {
    dialect.KITE_STATUS_STALE: "samples are stale",
    dialect.KITE_STATUS_SATURATED: "steering at its limit",
    dialect.KITE_STATUS_SLEWED: "steering rate at its limit",
    dialect.KITE_STATUS_COASTING: "coasting",
    dialect.KITE_STATUS_AIRSPEED_FLOOR: "airspeed at its floor",
}


def table(state: VehicleState, connection: Connection, link: str) -> list[str]:
    """The lines of the live table; the texts come last, newest first."""
    now_s = connection.clock()
    lines = [_title(state, connection, link), ""]
    lines += [f"  {name:<16}{value}" for name, value in [*_flight(state), *_loop(state), *_link(connection)]]
    lines += ["", "  messages of the vehicle"]
    texts = [f"  {now_s - text.time_s:6.0f} s ago   {text.severity_name:<10}{text.text}"
             for text in reversed(state.texts)]
    return lines + (texts or ["  none yet"])


def line(state: VehicleState, connection: Connection, elapsed_s: float) -> str:
    """The same in one line of key=value, for logs and pipes."""
    now_s, kite, statistics = connection.clock(), state.kite, connection.statistics
    loss = statistics.loss(now_s)
    parts = [f"t={elapsed_s:.1f}", f"mode={state.mode_name}", f"armed={'yes' if state.armed else 'no'}"]
    if kite is not None:
        parts += [
            f"cross_track_deg={_degrees(kite.cross_track)}", f"turning_angle_deg={_degrees(kite.course)}",
            f"target_deg={_degrees(kite.target_course)}", f"steering={kite.steering_asked:+.3f}",
            f"airspeed={kite.airspeed:.1f}", f"tick_ms={_tick(kite.tick_us)}", f"worst_ms={_tick(kite.tick_worst_us)}",
            f"overruns={kite.overruns}", f"dropped={kite.samples_dropped}"]
    parts += [f"rate={statistics.rate_hz(now_s):.1f}", f"loss={'-' if loss is None else f'{loss:.3f}'}",
              f"age={_silence_s(connection):.2f}"]
    return " ".join(parts)


def _title(state: VehicleState, connection: Connection, link: str) -> str:
    name = f"kite {connection.target.system} on {link}"
    if (silent_s := _silence_s(connection)) > STALE_S:
        return f"{name}   NO MESSAGE FOR {silent_s:.0f} s: all below is old"
    armed = {None: "", True: "ARMED", False: "disarmed"}[state.armed]
    return f"{name}   {state.mode_name}   {armed}"


def _flight(state: VehicleState) -> list[tuple[str, str]]:
    kite = state.kite
    if kite is None:
        return [("state", "no KITE_STATE has come: is STATE_HZ 0?")]
    error = math.remainder(kite.course - kite.target_course, math.tau)
    force = f"{kite.tether_force:8.0f} N" if kite.valid & dialect.KITE_VALID_TETHER_FORCE else "       - not measured"
    measured = f"{kite.steering:+.3f}" if kite.valid & dialect.KITE_VALID_STEERING else "-"
    airspeed = "" if kite.valid & dialect.KITE_VALID_AIRSPEED else "   assumed, not measured"
    limits = ", ".join(name for bit, name in _STATUS_NAMES.items() if kite.status & bit)
    return [
        ("cross-track", f"{_degrees(kite.cross_track):>8} deg"),
        ("turning angle", f"{_degrees(kite.course):>8} deg   target {_degrees(kite.target_course):>8} deg"
                          f"   error {_degrees(error):>8} deg"),
        ("azimuth", f"{_degrees(kite.azimuth):>8} deg   elevation {_degrees(kite.elevation):>5} deg"),
        ("steering", f"{kite.steering_asked:>+8.3f}       measured {measured}"),
        ("airspeed", f"{kite.airspeed:8.1f} m/s{airspeed}"),
        ("tether force", force),
        ("limits", limits or "none"),
    ]


def _loop(state: VehicleState) -> list[tuple[str, str]]:
    kite = state.kite
    rows = []
    if kite is not None:
        worst = _tick(kite.tick_worst_us)
        rows = [("loop", f"{_tick(kite.tick_us):>8} ms    worst {worst} ms   overruns {kite.overruns}"),
                ("samples dropped", f"{kite.samples_dropped:8d}")]
    if state.system is not None:
        rows.append(("load", f"{state.system.load / 10.0:8.1f} %     of the loop's period"))
    return rows


def _link(connection: Connection) -> list[tuple[str, str]]:
    now_s, statistics = connection.clock(), connection.statistics
    answer, loss = connection.round_trip.seconds, statistics.loss(now_s)
    answer_text = "-" if answer is None else f"{answer * 1e3:.0f} ms"
    return [("link", f"{statistics.rate_hz(now_s):8.1f} messages/s   lost {'-' if loss is None else f'{loss:.1%}'}"
                     f"   round trip {answer_text}   last message {_silence_s(connection):.1f} s ago")]


def _silence_s(connection: Connection) -> float:
    """How long ago the vehicle's last message came [s]; 0 before the first."""
    return connection.silence_s(connection.statistics.last_s or connection.clock())


def _degrees(angle_rad: float) -> str:
    return f"{math.degrees(angle_rad):+.1f}"


def _tick(time_us: int) -> str:
    return f"{time_us / 1e3:.2f}" if time_us < 65535 else ">65.5"
