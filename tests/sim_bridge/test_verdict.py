"""The verdict: four words, by where the kite really was, whatever it or anybody else says."""

import json
import re
from typing import Any

import numpy as np
import pytest

from kite_analysis.angles import wrap
from kite_analysis.verdicts import VERDICTS
from protocol import dialect
from sim_bridge.cli.main import main
from sim_bridge.flight.flight import Flight
from sim_bridge.flight.truth_columns import COLUMNS
from sim_bridge.links.ground_path import GroundLink
from sim_bridge.links.link_settings import PathSettings
from sim_bridge.runs.run import RunOptions, run_scenario
from sim_bridge.runtimes.memory import MemoryRuntime
from sim_bridge.scenario.scenario import Scenario, load_scenario

NUMBERS = ("cross_track_rms_rad", "cross_track_max_rad", "turning_angle_rms_rad", "steering_rms", "saturated_fraction")


class Operator:
    """A ground station that sends each message of its `plan` (time [s], message), and reads nothing."""

    def __init__(self, *plan: tuple[float, Any]):
        self.flight: Flight | None = None
        self._mav = dialect.MAVLink(None, srcSystem=255, srcComponent=190)
        self._plan = sorted(plan, key=lambda entry: entry[0])

    def receive(self) -> list[bytes]:
        """What it sends in this tick."""
        assert self.flight
        due = [message for time_s, message in self._plan if time_s <= self.flight.time_s + 1e-9]
        del self._plan[: len(due)]
        return [self._frame(message) for message in due]

    def send(self, frames: list[bytes]) -> None:
        """What it would hear."""

    def _frame(self, message: Any) -> bytes:
        self._mav.seq = (self._mav.seq + 1) % 256  # a frame with the number of the one before is its late copy
        return message.pack(self._mav)


def command(number: int, *values: float) -> Any:
    return dialect.MAVLink_command_long_message(1, 1, number, 0, *values, *[0.0] * (7 - len(values)))


def mode(number: int) -> Any:
    return command(dialect.MAV_CMD_DO_SET_MODE, 1.0, float(number))


def parameter(name: bytes, value: float) -> Any:
    return dialect.MAVLink_param_set_message(1, 1, name, value, dialect.MAV_PARAM_TYPE_REAL32)


DISARM = command(dialect.MAV_CMD_COMPONENT_ARM_DISARM, 0.0)
PARK, TRACK = mode(dialect.KITE_MODE_PARK), mode(dialect.KITE_MODE_TRACK)
SILENT = [command(dialect.MAV_CMD_SET_MESSAGE_INTERVAL, float(message), -1.0) for message in (
    dialect.MAVLINK_MSG_ID_KITE_STATE, dialect.MAVLINK_MSG_ID_CURRENT_MODE, dialect.MAVLINK_MSG_ID_SYS_STATUS,
    dialect.MAVLINK_MSG_ID_LOCAL_POSITION_NED, dialect.MAVLINK_MSG_ID_HEARTBEAT)]


def scenario_of(name: str, seconds: float, **parameters: float) -> Scenario:
    scenario = load_scenario(name)
    scenario.set("run.duration_s", seconds, "test")
    for key, value in parameters.items():
        scenario.set_parameter(key, value, "test")
    return scenario


def operated(*plan: tuple[float, Any], name: str = "small-kite", seconds: float = 30.0) -> Flight:
    """A flight with an operator at work."""
    operator = Operator(*plan)
    scenario = scenario_of(name, seconds)
    flight = Flight(scenario, MemoryRuntime(), GroundLink(PathSettings(), 1), operator)
    operator.flight = flight
    flight.fly(seconds)
    return flight


@pytest.mark.parametrize(("name", "verdict"), [
    ("paper-no-delay", "tracking"), ("paper-delay", "unstable"), ("small-kite", "tracking")])
def test_without_any_telemetry_the_same_flight_has_the_same_numbers(name, verdict):
    heard, silent = (run_scenario(scenario_of(name, 25.0, STATE_HZ=rate), RunOptions()).numbers for rate in (50.0, 0.0))
    assert heard["verdict"] == silent["verdict"] == verdict
    assert [heard[key] for key in NUMBERS] == [silent[key] for key in NUMBERS]


def test_without_delay_the_yardstick_is_what_the_firmware_steers_for():
    flight = run_scenario(scenario_of("paper-no-delay", 60.0), RunOptions()).flight
    told = np.array([row[COLUMNS.index("target_course_rad")] for row in flight.rows])
    assert np.max(np.abs(wrap(flight.track().target_course - told))) < 1e-3  # the crossing, the turns, everywhere


@pytest.mark.parametrize("said", [[], [(5.0, message) for message in SILENT]], ids=["telemetry", "silenced"])
@pytest.mark.parametrize(("plan", "verdict", "away_s"), [
    ([], "tracking", None),
    ([(3.0, PARK), (4.0, TRACK)], "tracking", None),  # before it is measured
    ([(20.0, PARK), (20.1, TRACK)], "lost", 0.2),  # and the curve is checked before the way back
    ([(20.0, PARK)], "lost", 10.0),
    ([(15.0, DISARM)], "lost", 15.0),
    ([(5.0, DISARM)], "lost", 20.0),
], ids=["undisturbed", "parked early", "parked for a moment", "parked", "disarmed", "disarmed early"])
def test_a_kite_out_of_track_is_lost_and_so_says_the_truth_alone(plan, verdict, away_s, said):
    metrics = operated(*plan, *said).metrics()
    assert metrics.verdict == verdict
    if away_s is None:
        assert metrics.trouble is None
        return
    said_s = re.search(r"^not in TRACK for ([\d.]+) s of the 20.0 s measured, first at", metrics.trouble or "")
    assert said_s and float(said_s[1]) == pytest.approx(away_s, abs=0.15)
    if away_s == 20.0:
        assert metrics.cross_track_rms_rad is None
    else:  # of the time in TRACK alone, but for the way back onto the eight
        assert metrics.cross_track_rms_rad is not None and metrics.cross_track_rms_rad < 0.06


def test_a_kite_that_nobody_steers_is_not_tracking_although_it_is_in_track():
    scenario = scenario_of("paper-no-delay", 30.0, PARK_ELEVATION=0.0)
    scenario.set("link.control.up.loss", 1.0, "test")
    assert run_scenario(scenario, RunOptions()).numbers["verdict"] == "unstable"


def test_an_eight_that_is_moved_in_flight_is_the_one_that_is_judged_by():
    moved = operated((12.0, parameter(b"EIGHT_AZIMUTH", 15.0)), (15.0, parameter(b"EIGHT_HALF_W", 45.0)), seconds=40.0)
    track = moved.track()
    assert moved.metrics().verdict == "tracking"
    assert np.max(track.cross_track[track.time_s > 20.0]) < 0.01
    assert track.half_width == pytest.approx(np.radians(45.0))
    cross_track, turning = moved.recent_errors(30.0)  # from before the move on
    assert 0.0 < cross_track < 0.1 and 0.0 < turning < 0.5


def test_a_flight_too_short_to_be_measured_says_so_and_has_no_numbers(capsys):
    assert main(["run", "paper-no-delay", "--duration", "5", "--json"]) == 0
    numbers = json.loads(capsys.readouterr().out)
    assert numbers["verdict"] == "not measured" and "run.settle_s = 10 s" in numbers["trouble"]
    assert [numbers[key] for key in NUMBERS] == [None] * 5
    assert main(["run", "paper-no-delay", "--duration", "5"]) == 0
    assert "not measured: the flight ended before run.settle_s = 10 s: fly longer" in capsys.readouterr().out


def test_help_explains_the_four_words(capsys):
    for verb in ("run", "sweep"):
        with pytest.raises(SystemExit):
            main([verb, "--help"])
        said = capsys.readouterr().out
        assert all(f"\n  {word} " in said for word in VERDICTS)
