"""The scenario's sections `start` and `run`: where a flight begins, and how long it is."""

from dataclasses import dataclass

from sim_bridge.settings import Settings, number, whole_number


@dataclass(frozen=True, kw_only=True)
class StartSettings(Settings):
    """Where a flight starts, seen from the eight."""

    path_parameter: float = number(0.0, "where on the eight the flight starts: s [rad]", -100.0, 100.0)
    offset_rad: float = number(
        0.0, "initial cross-track offset, positive to the right, towards e2 when flying up [rad]", -1.5, 1.5)
    course_error_rad: float = number(0.0, "initial course minus the curve's [rad]", -3.2, 3.2)


@dataclass(frozen=True, kw_only=True)
class RunSettings(Settings):
    """How long a flight is, what of it counts, and what everything random in it comes from."""

    duration_s: float = number(60.0, "length of the flight [s]", 0.1, 1e6)
    settle_s: float = number(10.0, "metrics start at this time [s]", 0.0, 1e6)
    seed: int = whole_number(1, "seed of all random numbers", 0, 2**63 - 1)
