"""The plant against what can be worked out on paper."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kite_analysis.figure_eight import great_circle_distance, turning_angle
from sim_bridge.flight.plant_choice import make_plant
from sim_bridge.scenario.scenario import Scenario
from sim_bridge.wind.air import Air

AIR = Air(8.0)
angles = st.floats(-3.0, 3.0)
elevations = st.floats(-1.2, 1.2)


def plant_at(azimuth, elevation, course, **changes):
    scenario = Scenario("test")
    for key, value in changes.items():
        scenario.set(key.replace("__", "."), value, "test")
    c, s = math.cos(elevation), math.sin(elevation)
    up = np.array([-s * math.cos(azimuth), -s * math.sin(azimuth), c])
    across = np.array([math.sin(azimuth), -math.cos(azimuth), 0.0])
    position = (c * math.cos(azimuth), c * math.sin(azimuth), s)
    direction = math.cos(course) * up + math.sin(course) * across
    return make_plant(scenario, position, tuple(direction))


@settings(deadline=None, max_examples=50)
@given(angles, elevations, angles)
def test_without_steering_it_flies_a_great_circle_at_the_given_speed(azimuth, elevation, course):
    plant = plant_at(azimuth, elevation, course, plant__speed_over_length=0.3)
    start = plant.truth()
    normal = np.cross(start.position, start.velocity)
    for _ in range(300):
        plant.step(0.01, 0.0, AIR)
    end = plant.truth()
    assert abs(normal @ np.array(end.position)) < 1e-9
    assert great_circle_distance(np.array(start.position), np.array(end.position)) == pytest.approx(0.9, abs=1e-9)
    assert np.linalg.norm(end.position) == pytest.approx(1.0, abs=1e-12)


@settings(deadline=None, max_examples=50)
@given(angles, elevations, angles, st.floats(0.05, 1.0))
def test_constant_steering_flies_a_small_circle_of_the_tightest_turns_radius(azimuth, elevation, course, steering):
    """Angular radius rho with tan(rho) = (v/R) / (K Va u); back at the start after a whole turn."""
    changes = {"plant__speed_over_length": 0.5, "plant__turn_k": 0.3, "plant__airspeed_m_s": 20.0,
               "plant__line_length_m": 40.0}
    plant = plant_at(azimuth, elevation, course, **changes)
    turning = 0.3 * 20.0 * steering
    period = 2 * math.pi / math.hypot(turning, 0.5)
    start, positions = plant.truth(), []
    for _ in range(400):
        plant.step(period / 400, steering, AIR)
        positions.append(plant.truth().position)
    end = plant.truth()
    assert end.position == pytest.approx(start.position, abs=1e-9)
    centre = np.mean(positions, axis=0)
    radius = great_circle_distance(np.array(start.position), centre / np.linalg.norm(centre))
    assert math.tan(radius) == pytest.approx(0.5 / turning, rel=1e-6)


def test_positive_steering_turns_the_heading_positively_and_up_is_zero():
    plant = plant_at(0.0, 0.0, 0.0, plant__speed_over_length=0.1)
    assert plant.truth().course == pytest.approx(0.0)
    plant.step(0.05, 0.2, AIR)
    truth = plant.truth()
    assert truth.course > 0.0
    assert truth.velocity[2] > 0.0 and truth.velocity[1] < 0.0  # up, and from there towards -y


def test_without_transport_the_turning_angle_obeys_the_papers_law_alone():
    plant = plant_at(0.4, 0.7, 1.0, plant__transport=False, plant__turn_k=0.1, plant__airspeed_m_s=10.0)
    for _ in range(100):
        plant.step(0.01, 0.2, AIR)
    assert plant.truth().course == pytest.approx(1.0 + 0.1 * 10.0 * 0.2 * 1.0, abs=1e-6)


def test_gravity_turns_the_nose_down_by_the_laws_amount():
    """At rest beside the meridian the rate is c2 / Va sin(psi) cos(elevation)."""
    plant = plant_at(0.0, 0.6, 0.5, plant__gravity_m_s2=4.0, plant__airspeed_m_s=20.0,
                     plant__speed_over_length=1e-3)
    plant.step(0.01, 0.0, AIR)
    rate = (plant.truth().heading - 0.5) / 0.01
    assert rate == pytest.approx(4.0 / 20.0 * math.sin(0.5) * math.cos(0.6), rel=0.01)


def test_glide_law_gives_erhard_and_strauchs_airspeed_and_a_drift_with_the_wind():
    plant = plant_at(0.3, 0.5, 1.2, plant__speed_law="glide", plant__glide_ratio=4.0, wind__speed_m_s=9.0,
                     plant__line_length_m=200.0)
    truth = plant.truth()
    position = np.array(truth.position)
    assert truth.airspeed == pytest.approx(9.0 * 4.0 * position[0])
    wind = np.array([9.0, 0.0, 0.0])
    drift = wind - (wind @ position) * position
    nose = np.array(truth.velocity) * 200.0 - drift
    assert np.linalg.norm(nose) == pytest.approx(truth.airspeed)
    assert turning_angle(position, nose) == pytest.approx(truth.heading)
    assert truth.course != pytest.approx(truth.heading, abs=0.01)


def test_integration_is_of_second_order_where_it_is_not_exact():
    def end(step):
        plant = plant_at(0.0, 0.6, 1.0, plant__speed_law="glide", plant__gravity_m_s2=4.0, wind__speed_m_s=8.0)
        for tick in range(round(4.0 / step)):
            plant.step(step, 0.1 * math.sin(tick * step + step / 2), AIR)
        return np.array(plant.truth().position)

    best = end(0.000625)
    errors = [float(np.linalg.norm(end(step) - best)) for step in (0.02, 0.01, 0.005)]
    assert errors[0] < 1e-4
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.2)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.2)


@pytest.mark.parametrize("law", ["constant", "glide"])
def test_with_no_wind_it_stands_still_and_nothing_turns_it(law):
    plant = plant_at(0.3, 0.6, 1.2, plant__speed_law=law, plant__gravity_m_s2=4.0, plant__offset_rad_s=0.3)
    plant.step(0.01, 0.2, AIR)
    before = plant.truth()
    for _ in range(100):
        plant.step(0.01, 1.0, Air(0.0, 0.5, 0.1, 0.1, 0.1))
    after = plant.truth()
    assert after.airspeed == 0.0 and after.velocity == (0.0, 0.0, 0.0)
    assert after.position == before.position and after.heading == after.course == before.heading
    plant.step(0.01, 0.2, AIR)
    assert plant.truth().airspeed == pytest.approx(before.airspeed, rel=0.01)


def test_the_constant_law_scales_airspeed_and_speed_with_the_wind_and_its_gusts_along():
    plant = plant_at(0.3, 0.6, 1.2, plant__airspeed_m_s=20.0, plant__speed_over_length=0.3, wind__speed_m_s=8.0)
    plant.step(0.01, 0.2, Air(6.0, 1.0, 0.2, 0.3, 0.3))
    truth = plant.truth()
    assert truth.airspeed == pytest.approx(20.0 * 6.0 / 8.0 * 1.2)
    assert np.linalg.norm(truth.velocity) == pytest.approx(0.3 * 6.0 / 8.0 * 1.2)


def fly_in(air, azimuth, **changes):
    """A glide-law kite after 5 s of steering to and fro in `air`."""
    plant = plant_at(azimuth, 0.5, 1.2, plant__speed_law="glide", plant__gravity_m_s2=4.0, **changes)
    for tick in range(500):
        plant.step(0.01, 0.3 * math.sin(0.02 * tick), air)
    return plant.truth()


def test_in_a_wind_that_blows_elsewhere_the_glide_law_flies_the_same_way_turned():
    straight, turned = fly_in(Air(8.0), 0.2), fly_in(Air(8.0, 0.7), 0.9)
    x, y, z = straight.position
    c, s = math.cos(0.7), math.sin(0.7)
    assert turned.position == pytest.approx((c * x - s * y, s * x + c * y, z), abs=1e-9)
    assert (turned.course, turned.airspeed) == pytest.approx((straight.course, straight.airspeed))


def test_a_gust_across_is_a_wind_that_is_turned_and_a_little_stronger():
    gusty = fly_in(Air(8.0, 0.1, across=0.3), 0.2)
    turned = fly_in(Air(8.0 * math.hypot(1.0, 0.3), 0.1 + math.atan(0.3)), 0.2)
    assert gusty.position == pytest.approx(turned.position, abs=1e-9)
    assert gusty.airspeed == pytest.approx(turned.airspeed)


def test_a_vertical_gust_pulls_along_the_tether_and_lifts_the_kite():
    """At azimuth 0, elevation E the tether's part of the wind is m (cos E + vertical sin E)."""
    plant = plant_at(0.0, 0.5, math.pi / 2, plant__speed_law="glide", plant__glide_ratio=4.0,
                     plant__line_length_m=200.0)
    plant.step(1e-9, 0.0, Air(8.0, vertical=0.25))
    truth = plant.truth()
    assert truth.airspeed == pytest.approx(4.0 * 8.0 * (math.cos(0.5) + 0.25 * math.sin(0.5)), rel=1e-6)
    up_the_sphere = 8.0 * (0.25 * math.cos(0.5) - math.sin(0.5))
    assert truth.velocity[2] * 200.0 == pytest.approx(up_the_sphere * math.cos(0.5), rel=1e-6)


def test_the_glide_law_has_the_wind_of_its_height():
    """200 m of line at an elevation of 30 deg: 100 m, where the reference gives 1.494685 for the power law."""
    for profile, factor in (("constant", 1.0), ("exp", 1.494685)):
        plant = plant_at(0.0, math.radians(30.0), 1.0, plant__speed_law="glide", plant__glide_ratio=4.0,
                         plant__line_length_m=200.0, wind__profile=profile)
        airspeed = 8.0 * factor * 4.0 * math.cos(math.radians(30.0))
        assert plant.truth().airspeed == pytest.approx(airspeed, rel=1e-6)
