"""What errors of sensors and actuator do to whole flights: directions, not numbers."""

import json
from functools import cache
from typing import Any

import pytest

from protocol.messages import KiteSensors
from sim_bridge.cli.main import main
from sim_bridge.flight.flight import Flight
from sim_bridge.flight.tick_record import TickRecord
from sim_bridge.runs.run import RunOptions, run_scenario
from sim_bridge.runtimes.inproc import InprocRuntime
from sim_bridge.runtimes.tick_output import clock_us
from sim_bridge.scenario.scenario import load_scenario

TEN_DEG = 0.1745
KITES = "small-kite-one-point", "v3-flight"


@cache
def flown(name: str, changes: tuple[tuple[str, float], ...] = (), **parameters: float) -> dict[str, Any]:
    """Numbers of a minute's flight, and the truth of it."""
    scenario = load_scenario(name)
    for key, value in changes:
        scenario.set(key, value, "test")
    for parameter, value in parameters.items():
        scenario.set_parameter(parameter, value, "test")
    result = run_scenario(scenario, RunOptions(until_s=60.0))
    return result.numbers | {"rows": result.flight.rows}


def with_errors(name: str, **errors: float) -> dict[str, Any]:
    """Flown with keys that are written with two underscores for a dot."""
    return flown(name, tuple((key.replace("__", "."), value) for key, value in errors.items()))


@pytest.mark.parametrize("name", ["small-kite", *KITES])
def test_a_compass_that_is_off_by_ten_degrees_leads_the_kite_off_its_eight(name):
    off = with_errors(name, errors__course__bias=TEN_DEG, errors__heading__bias=TEN_DEG)
    assert off["verdict"] == "tracking"
    assert off["cross_track_rms_rad"] > 1.4 * flown(name)["cross_track_rms_rad"]


def test_a_course_that_comes_late_makes_a_loop_unstable_that_was_tuned_without():
    assert with_errors("v3-flight", errors__course__lag_s=0.4)["verdict"] == "unstable"
    stamped = with_errors("v3-flight", errors__course__lag_s=0.02)
    assert stamped["verdict"] == "tracking"


def test_an_airspeed_that_reads_low_is_answered_with_more_steering():
    for name in KITES:
        low = with_errors(name, errors__airspeed__scale=0.8)
        assert low["steering_travel_per_s"] > 1.3 * flown(name)["steering_travel_per_s"]


def test_a_position_off_by_three_degrees_moves_the_eight_by_as_much():
    off = with_errors("small-kite", errors__position__bias=0.05)
    assert 0.025 < off["cross_track_rms_rad"] < 0.075 < 200.0 * flown("small-kite")["cross_track_rms_rad"]


def test_a_noisy_position_makes_the_actuator_work_for_nothing():
    noisy, exact = with_errors("v3-flight", errors__position__noise=0.001), flown("v3-flight")
    assert noisy["steering_asked_travel_per_s"] > 5.0 * exact["steering_asked_travel_per_s"]
    assert noisy["steering_travel_per_s"] > 1.5 * exact["steering_travel_per_s"]
    assert noisy["steering_travel_per_s"] <= 0.21 + 1e-9  # which is all it can
    assert noisy["cross_track_rms_rad"] > exact["cross_track_rms_rad"]


def test_a_position_that_is_missing_now_and_then_is_flown_over_and_one_missing_for_long_is_not():
    seldom = with_errors("v3-flight", errors__position__dropout=0.5)
    assert seldom["verdict"] == "tracking"
    assert seldom["cross_track_rms_rad"] > flown("v3-flight")["cross_track_rms_rad"]
    long = with_errors("v3-flight", errors__position__dropout=0.05, errors__position__dropout_s=1.0)
    assert long["verdict"] == "lost" and "not in TRACK" in long["trouble"]


def test_a_steering_that_reads_high_spoils_what_is_learnt_of_the_kite():
    high = flown("small-kite", (("errors.steering.scale", 1.3),), K_ADAPT=1.0)
    assert high["cross_track_rms_rad"] > 10.0 * flown("small-kite", K_ADAPT=1.0)["cross_track_rms_rad"]


def test_a_distance_that_reads_double_changes_gains_that_follow_it_and_no_others():
    double = (("errors.distance.scale", 2.0),)
    assert flown(KITES[0], double)["rows"] == flown(KITES[0])["rows"]
    assert flown(KITES[0], double, GAIN_TAU=0.2)["rows"] != flown(KITES[0], GAIN_TAU=0.2)["rows"]


def test_a_tether_force_that_reads_wrong_changes_no_flight():
    wrong = with_errors(KITES[0], errors__tether_force__bias=500.0, errors__tether_force__dropout=0.5)
    assert wrong["rows"] == flown(KITES[0])["rows"]


def test_play_makes_the_autopilot_ask_for_more_and_turns_the_kite_later():
    loose, tight = with_errors(KITES[0], actuator__backlash=0.1), flown(KITES[0])
    assert loose["steering_asked_travel_per_s"] > 1.15 * tight["steering_asked_travel_per_s"]
    assert loose["turning_angle_rms_rad"] > 1.2 * tight["turning_angle_rms_rad"]
    assert loose["steering_travel_per_s"] < loose["steering_asked_travel_per_s"] - 0.1  # the rest is lost in the play


def test_a_dead_band_spares_the_actuator_of_a_noisy_kite_and_costs_accuracy():
    noise = {"sensors__course_noise_rad": 0.05}
    restless, calm = with_errors(KITES[0], **noise), with_errors(KITES[0], **noise, actuator__dead_band=0.05)
    assert calm["steering_travel_per_s"] < 0.85 * restless["steering_travel_per_s"]
    assert calm["turning_angle_rms_rad"] > restless["turning_angle_rms_rad"]


def test_the_firmware_is_told_where_the_motor_is_and_not_where_the_play_leaves_the_steering():
    scenario = load_scenario("small-kite")
    scenario.set("actuator.backlash", 0.2, "test")
    ticks: list[TickRecord] = []
    Flight(scenario, InprocRuntime(), watch=ticks.append).fly(10.0)
    told = {sample.time_us: sample.steering for tick in ticks for sample in map(KiteSensors._make, tick.samples)}
    rows = {clock_us(tick.time_s): tick.row for tick in ticks if tick.row}
    apart = [abs(told[time_us] - row.steering) for time_us, row in rows.items() if time_us in told]
    assert len(apart) > 400
    assert 0.09 < max(apart) < 0.1 + 1e-6
    assert max(abs(told[time_us]) - abs(row.steering) for time_us, row in rows.items() if time_us in told) > 0.09


def test_report_and_json_tell_what_actuator_and_tether_had_to_bear(capsys):
    asked = ("run", "small-kite-one-point", "--duration", "20")
    assert main([*asked, "--json"]) == 0
    numbers = json.loads(capsys.readouterr().out)
    assert main(asked) == 0
    said = capsys.readouterr().out
    for text in (f"steering travel {numbers['steering_travel_per_s']:.3f} per second",
                 f"{numbers['steering_asked_travel_per_s']:.3f} commanded",
                 f"peak tether force {numbers['peak_tether_force_n']:.0f} N"):
        assert text in said
    assert main(["run", "small-kite", "--duration", "20"]) == 0
    assert "tether force" not in capsys.readouterr().out
