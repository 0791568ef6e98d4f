"""Parts are made from their settings in a line, refuse in a line what they cannot take, and get what a key says."""

import math
from dataclasses import FrozenInstanceError, fields

import pytest

from sim_bridge.equipment.actuator import Actuator
from sim_bridge.equipment.actuator_settings import ActuatorSettings
from sim_bridge.equipment.error_settings import QUANTITIES, ErrorSettings, MeasurementErrors
from sim_bridge.equipment.sensor_settings import SensorSettings
from sim_bridge.equipment.sensors import Sensors
from sim_bridge.links.emulation import LinkDirection
from sim_bridge.links.ground_settings import GroundSettings
from sim_bridge.links.link_settings import LinkSettings
from sim_bridge.plants.four_point import FourPointKite
from sim_bridge.plants.four_point_settings import FourPointFrame, FourPointSettings
from sim_bridge.plants.kite_settings import KiteSettings, OnePointSettings
from sim_bridge.plants.one_point import OnePointKite
from sim_bridge.plants.tether_settings import TetherSettings
from sim_bridge.plants.turning_rate import TurningRatePlant
from sim_bridge.plants.turning_rate_settings import TurningRateSettings
from sim_bridge.plants.vortex_lattice.plant import VortexLatticeKite
from sim_bridge.plants.vortex_lattice.wing_settings import VortexLatticeSettings, WingSettings
from sim_bridge.scenario.keys import KEYS, plants_that_know
from sim_bridge.scenario.plant_names import PLANTS
from sim_bridge.scenario.scenario import Scenario
from sim_bridge.settings import Settings
from sim_bridge.wind.air import Air
from sim_bridge.wind.wind import Wind
from sim_bridge.wind.wind_settings import WindSettings

WIND = WindSettings(speed_m_s=8.0)
HERE, SIDEWAYS = (math.cos(0.6), 0.0, math.sin(0.6)), (0.0, -1.0, 0.0)


@pytest.mark.parametrize("kite", [
    lambda: TurningRatePlant(TurningRateSettings(turn_k=0.3), WIND, HERE, SIDEWAYS),
    lambda: OnePointKite(OnePointSettings(line_length_m=60.0), WIND, HERE, SIDEWAYS),
    lambda: FourPointKite(FourPointSettings(line_length_m=150.0), WIND, HERE, SIDEWAYS),
    lambda: VortexLatticeKite(VortexLatticeSettings(wing=WingSettings(strips=8)), WIND, HERE, SIDEWAYS),
], ids=PLANTS)
def test_a_kite_is_made_in_a_line_and_turns_as_it_is_steered(kite):
    plants = kite(), kite()
    for plant, steering in zip(plants, (0.2, -0.2), strict=True):
        for _ in range(40):
            plant.step(0.01, steering, Air(8.0))
        assert plant.trouble is None
    positive, negative = (plant.truth().heading - math.pi / 2 for plant in plants)
    assert positive > 0.1 > -0.1 > negative


def test_an_actuator_sensors_a_link_and_a_wind_are_made_in_a_line():
    actuator = Actuator(ActuatorSettings(dead_time_s=0.2, rate_limit_per_s=2))
    actuator.command(0.0, 1.0)
    actuator.apply_due(0.2)
    actuator.advance(0.25)
    assert actuator.position == pytest.approx(0.5)
    link = LinkDirection(LinkSettings(delay_s=0.1), seed="1")
    link.send(0.0, "a frame", size=50)
    parcel, = link.due(0.1)
    assert (parcel.time_s, parcel.item) == (0.1, "a frame")
    wind = Wind(WindSettings(gusts="dryden", turbulence_intensity=0.1), period_s=0.02, seed=1, height_m=60.0)
    wind.advance()
    assert wind.air.speed_m_s == 8.0 and wind.air.along
    truth = TurningRatePlant(TurningRateSettings(line_length_m=60.0), WIND, HERE, SIDEWAYS).truth()
    sample = Sensors(SensorSettings(resolution_rad=0.25), seed=1).sample(0, truth, 0.0)
    assert sample[2:4] == (0.5, 60.0)  # 0.6 rad, in steps of 0.25
    sensors = Sensors(SensorSettings(), 1, MeasurementErrors(distance=ErrorSettings(scale=0.5, bias=1.0)))
    sensors.follow(0.0, truth, 0.0)
    assert sensors.sample(0, truth, 0.0)[3] == 31.0


@pytest.mark.parametrize(("kind", "values", "says"), [
    (ActuatorSettings, {"dead_time_s": 7.0}, "ActuatorSettings: dead_time_s = 7 is outside 0 to 5"),
    (ActuatorSettings, {"lag_s": math.nan}, "ActuatorSettings: lag_s = nan is outside 0 to 5"),
    (ActuatorSettings, {"lag_s": "0.1"}, "ActuatorSettings: lag_s takes a number, not '0.1'"),
    (LinkSettings, {"loss": 1.5}, "LinkSettings: loss = 1.5 is outside 0 to 1"),
    (SensorSettings, {"course": 1}, "SensorSettings: course takes true or false, not 1"),
    (ErrorSettings, {"dropout": 1.5}, "ErrorSettings: dropout = 1.5 is outside 0 to 1"),
    (WindSettings, {"gusts": "dreiden"},
     "WindSettings: gusts is one of first-order, dryden, von-karman; did you mean dryden?"),
    (TurningRateSettings, {"turn_k": 0.0}, "TurningRateSettings: turn_k = 0 is outside 0.0001 to 100"),
    (TetherSettings, {"segments": 2.5}, "TetherSettings: segments takes a whole number, not 2.5"),
    (KiteSettings, {"lift_coefficients": (0.0, 11.0)}, "KiteSettings: lift_coefficients: 11 is outside -10 to 10"),
    (FourPointFrame, {"width_m": None}, "FourPointFrame: width_m takes a number, not None"),
    (GroundSettings, {"listen": 14551}, "GroundSettings: listen takes text, not 14551"),
])
def test_what_a_part_cannot_take_is_said_in_one_line(kind, values, says):
    with pytest.raises(ValueError) as error:
        kind(**values)
    assert str(error.value) == says


def test_settings_stay_as_they_were_made_and_say_what_they_take():
    settings = ActuatorSettings(rate_limit_per_s=2)
    assert isinstance(settings.rate_limit_per_s, float)
    with pytest.raises(FrozenInstanceError):
        settings.lag_s = 0.1  # type: ignore[misc]
    line = "dead_time_s: dead time from command to actual steering [s] (0 to 5; default 0.0)"
    assert line in (ActuatorSettings.__doc__ or "")
    assert WindSettings().convection_m_s is None


def handed_out(scenario):
    """Every setting that the parts of a flight get, by a dotted name."""
    link = scenario.link
    held = {
        "plant": scenario.plant, "wind": scenario.wind, "actuator": scenario.actuator, "sensors": scenario.sensors,
        "link.control.down": link.control.down, "link.control.up": link.control.up,
        "link.ground.down": link.ground.down, "link.ground.up": link.ground.up,
        "ground": scenario.ground, "start": scenario.start, "run": scenario.run,
        **{f"errors.{quantity}": errors for quantity, errors in scenario.errors._asdict().items()}}
    found = {}
    while held:
        section, settings = held.popitem()
        for field in fields(settings):
            value = getattr(settings, field.name)
            if isinstance(value, Settings):
                held[field.name] = value
            else:
                found[f"{section}.{field.name}"] = value
    return found


def another_value(key):
    """One that the key takes, and not its default."""
    if key.kind is bool:
        return not key.default
    if key.kind is str:
        return key.choices[-1] if key.choices else "something else"
    if key.kind is tuple:
        return (0.5, 0.25)
    least, greatest = key.kind(key.least), key.kind(key.greatest)
    return greatest if key.default != greatest else least


@pytest.mark.parametrize("plant", PLANTS)
def test_each_key_changes_the_one_setting_of_its_name(plant):
    """But for a path's own keys, which are felt both ways."""
    scenario = Scenario("test")
    scenario.set("plant.kind", plant, "test")
    before = handed_out(scenario)
    for name, key in KEYS.items():
        if name in ("title", "plant.kind") or plant not in plants_that_know(name):
            continue
        changed = Scenario.from_dict(scenario.to_dict(), "test")
        changed.set(name, another_value(key), "test")
        after = handed_out(changed)
        path, _, field = name.rpartition(".")
        felt = {f"{path}.down.{field}", f"{path}.up.{field}"} if path in ("link.control", "link.ground") else {name}
        assert {name for name in after if after[name] != before[name]} == felt
    assert set(before) <= set(KEYS)
    assert tuple(QUANTITIES) == MeasurementErrors._fields
