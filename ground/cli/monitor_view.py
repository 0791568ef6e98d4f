"""Contents of the monitor: a table for a terminal, a line for a pipe. Angles in degrees."""

import math
import textwrap

from ground.link.connection import Connection
from ground.link.statistics import LinkStatistics
from ground.session import Session
from ground.vehicle.state import VehicleState
from kite_analysis.angles import wrap
from protocol import dialect

_DELAY_WINDOW_S = 30.0
_MOST_WARNED = 4  # lines
_STATUS_NAMES = {
    dialect.KITE_STATUS_STALE: "samples are stale",
    dialect.KITE_STATUS_SATURATED: "steering at its limit",
    dialect.KITE_STATUS_SLEWED: "steering rate at its limit",
    dialect.KITE_STATUS_COASTING: "coasting",
    dialect.KITE_STATUS_AIRSPEED_FLOOR: "airspeed at its minimum",
}


def screen(session: Session, warnings: list[str], width: int, height: int) -> list[str]:
    """At most `height` lines of at most `width` columns: title, warnings, flight, loop, links, messages."""
    state, connection = session.state, session.connection
    rows = [*_flight(state), *_loop(state), *_links(session)]
    lines = [_title(state, connection), *_warned(warnings, width), ""]
    lines += [f"  {name:<16}{value}" for name, value in rows]
    said = ["", "  messages, newest first", *(_messages(session) or ["  none yet"])]
    lines = [*lines, *said[: max(height - len(lines) - 1, 0)]]
    return [line[:width] for line in [*lines[: height - 1], "  Ctrl-C quits"]]


def line(state: VehicleState, connection: Connection, elapsed_s: float) -> str:
    """The state in one line of key=value, for logs and pipes."""
    now_s, kite, statistics = connection.clock(), state.kite, connection.statistics
    loss = statistics.loss(now_s)
    parts = [f"t={elapsed_s:.1f}", f"mode={state.mode_name}", f"armed={'yes' if state.armed else 'no'}"]
    if kite is not None:
        parts += [
            f"cross_track_deg={_degrees(kite.cross_track)}", f"turning_angle_deg={_degrees(kite.course)}",
            f"target_deg={_degrees(kite.target_course)}", f"steering={kite.steering_asked:+.3f}",
            f"airspeed={kite.airspeed:.1f}", f"tick_ms={_tick(kite.tick_us)}", f"worst_ms={_tick(kite.tick_worst_us)}",
            f"late_ms={_tick(kite.late_worst_us)}", f"overruns={kite.overruns}", f"dropped={kite.samples_dropped}"]
    if (delay := connection.round_trip.summary(now_s, _DELAY_WINDOW_S)) is not None:
        parts += [f"delay_ms={delay.median_s * 1e3:.0f}", f"spread_ms={delay.spread_s * 1e3:.0f}"]
    parts += [f"rate={statistics.rate_hz(now_s):.1f}", f"loss={'-' if loss is None else f'{loss:.3f}'}",
              f"age={_silence_s(connection):.2f}"]
    return " ".join(parts)


def _title(state: VehicleState, connection: Connection) -> str:
    armed = {None: "", True: "ARMED", False: "disarmed"}[state.armed]
    clock = connection.vehicle_clock
    running = f"   running for {_duration(clock.uptime_s + connection.clock() - clock.heard_s)}" if clock else ""
    return f"kite {connection.target.system}   {state.mode_name}   {armed}{running}"


def _warned(warnings: list[str], width: int) -> list[str]:
    """The warnings, wrapped; without any, a line that keeps the table in its place."""
    lines = [line for text in warnings
             for line in textwrap.wrap(text, max(width - 1, 20), initial_indent="! ", subsequent_indent="  ")]
    return lines[:_MOST_WARNED] or ["  all is well"]


def _flight(state: VehicleState) -> list[tuple[str, str]]:
    kite = state.kite
    if kite is None:
        return [("state", "no KITE_STATE received: is STATE_HZ 0?")]
    error = wrap(kite.course - kite.target_course)
    force = f"{kite.tether_force:8.0f} N" if kite.valid & dialect.KITE_VALID_TETHER_FORCE else "       - not measured"
    measured = f"{kite.steering:+.3f}" if kite.valid & dialect.KITE_VALID_STEERING else "-"
    airspeed = "" if kite.valid & dialect.KITE_VALID_AIRSPEED else "   assumed, not measured"
    limits = ", ".join(name for bit, name in _STATUS_NAMES.items() if kite.status & bit)
    return [
        ("cross-track", f"{_degrees(kite.cross_track):>8} deg"),
        ("turning angle", f"{_degrees(kite.course):>8} deg   target {_degrees(kite.target_course):>8} deg"
                          f"   error {_degrees(error):>8} deg"),
        ("azimuth", f"{_degrees(kite.azimuth):>8} deg   elevation {_degrees(kite.elevation):>5} deg"),
        ("steering", f"{kite.steering_asked:>+8.3f}       actual {measured}"),
        ("airspeed", f"{kite.airspeed:8.1f} m/s{airspeed}"),
        ("tether force", force),
        ("limits", limits or "none"),
    ]


def _loop(state: VehicleState) -> list[tuple[str, str]]:
    kite = state.kite
    rows = []
    if kite is not None:
        tick, worst, late = (_tick(time) for time in (kite.tick_us, kite.tick_worst_us, kite.late_worst_us))
        rows = [("loop", f"{tick:>8} ms    worst {worst} ms   late {late} ms   overruns {kite.overruns}"),
                ("samples dropped", f"{kite.samples_dropped:8d}")]
    if state.system is not None:
        rows.append(("load", f"{state.system.load / 10.0:8.1f} %     of the loop's period"))
    return rows


def _links(session: Session) -> list[tuple[str, str]]:
    connection = session.connection
    now_s = connection.clock()
    rows = [("link", _quality(connection.statistics, now_s))]
    if len(session.links.all) > 1:
        rows += [("", f"{_quality(link.statistics, now_s)}   {link.name}{' IS DOWN' if link.problem else ''}")
                 for link in session.links.all]
    delay = connection.round_trip.summary(now_s, _DELAY_WINDOW_S)
    if delay is None:
        return [*rows, ("round trip", "       - no answer yet")]
    lost = "" if delay.loss is None else f"   unanswered {delay.loss:.0%}"
    return [*rows, ("round trip", f"{delay.median_s * 1e3:8.0f} ms    90 % from {delay.low_s * 1e3:.0f} to "
                    f"{delay.high_s * 1e3:.0f} ms{lost}")]


def _quality(statistics: LinkStatistics, now_s: float) -> str:
    loss = statistics.loss(now_s)
    age = "none yet" if statistics.last_s is None else f"last {now_s - statistics.last_s:.1f} s ago"
    return f"{statistics.rate_hz(now_s):8.1f} /s    lost {'-' if loss is None else f'{loss:.1%}'}   {age}"


def _messages(session: Session) -> list[str]:
    """Messages of the vehicle and notices of the ground station, newest first."""
    now_s = session.connection.clock()
    said = [(text.time_s, f"{text.severity_name:<10}{text.text}") for text in session.state.texts]
    said += [(time_s, f"{'here':<10}{text}") for time_s, text in session.notices]
    return [f"  {now_s - time_s:6.0f} s ago   {text}" for time_s, text in sorted(said, reverse=True)]


def _duration(seconds: float) -> str:
    return f"{int(seconds // 3600)}:{int(seconds // 60) % 60:02}:{int(seconds) % 60:02}"


def _silence_s(connection: Connection) -> float:
    """Time since the vehicle's last message [s]; 0 before the first."""
    return connection.silence_s(connection.statistics.last_s or connection.clock())


def _degrees(angle_rad: float) -> str:
    return f"{math.degrees(angle_rad):+.1f}"


def _tick(time_us: int) -> str:
    return f"{time_us / 1e3:.2f}" if time_us < 65535 else ">65.5"
