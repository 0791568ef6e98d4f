"""Every key that a scenario may set: its default, its bounds, and what it means.

One table serves the reading of TOML files, `--set`, and `kite-sitl keys`. It is made of the types that the parts of a
flight have their settings in: a section is a type, and its keys are the type's fields.
"""

from sim_bridge.equipment.actuator_settings import ActuatorSettings
from sim_bridge.equipment.error_settings import QUANTITIES, ErrorSettings
from sim_bridge.equipment.sensor_settings import SensorSettings
from sim_bridge.links.ground_settings import GroundSettings
from sim_bridge.links.link_settings import LinkSettings
from sim_bridge.plants.four_point_settings import FourPointFrame, FourPointSettings
from sim_bridge.plants.kite_settings import KiteSettings, OnePointSettings
from sim_bridge.plants.tether_settings import TetherSettings
from sim_bridge.plants.turning_rate_settings import TurningRateSettings
from sim_bridge.plants.vortex_lattice.wing_settings import VortexLatticeSettings, WingSettings
from sim_bridge.scenario.flight_settings import RunSettings, StartSettings
from sim_bridge.scenario.plant_names import FOUR_POINT, ONE_POINT, PLANTS, TURNING_RATE, VORTEX_LATTICE
from sim_bridge.settings import Key, Settings, own_keys, parts
from sim_bridge.wind.wind_settings import WindSettings

PlantSettings = TurningRateSettings | OnePointSettings | FourPointSettings | VortexLatticeSettings
PLANT_SETTINGS: dict[str, type[PlantSettings]] = {
    TURNING_RATE: TurningRateSettings, ONE_POINT: OnePointSettings, FOUR_POINT: FourPointSettings,
    VORTEX_LATTICE: VortexLatticeSettings,
}
_IN_UNITS = ("noise", "wander", "bias")
_WAYS = {"down": "towards the firmware", "up": "from the firmware"}
_BOTH_WAYS = {"delay_s": "delay of both directions together, half each"}


def _section(name: str, kind: type[Settings]) -> dict[str, Key]:
    return {f"{name}.{field}": key for field, key in own_keys(kind).items()}


def _errors() -> dict[str, Key]:
    """Keys of the errors of each quantity, with its unit."""
    keys = {}
    for quantity, (what, unit) in QUANTITIES.items():
        for field, key in own_keys(ErrorSettings).items():
            in_unit = f" [{unit}]" if unit and field in _IN_UNITS else ""
            keys[f"errors.{quantity}.{field}"] = key._replace(text=f"{what}: {key.text}{in_unit}")
    return keys


def _path(name: str, what: str) -> dict[str, Key]:
    """Keys of a path: for both directions together, and for each alone (those win)."""
    link = own_keys(LinkSettings)
    keys = {f"link.{name}.{field}": key._replace(text=f"{what}: {_BOTH_WAYS.get(field, key.text)}")
            for field, key in link.items()}
    for direction, way in _WAYS.items():
        keys |= {f"link.{name}.{direction}.{field}": key._replace(
            default=None, text=f"{what}, {way}: {key.text} (unset: as for both)") for field, key in link.items()}
    return keys


KEYS: dict[str, Key] = {
    "title": Key("", "title of the scenario", kind=str),
    "plant.kind": Key(PLANTS[0], "plant to fly", choices=PLANTS, kind=str),
    **_section("plant", TurningRateSettings),
    **_section("wind", WindSettings),
    **_section("kite", KiteSettings),
    **_section("four_point", FourPointFrame),
    **_section("wing", WingSettings),
    **_section("tether", TetherSettings),
    **_section("actuator", ActuatorSettings),
    **_section("sensors", SensorSettings),
    **_errors(),
    **_path("control", "control path"),
    **_path("ground", "ground path"),
    **_section("ground", GroundSettings),
    **_section("start", StartSettings),
    **_section("run", RunSettings),
}


def plants_that_know(key: str) -> tuple[str, ...]:
    """The plants for which `key` means something."""
    knowing = tuple(plant for plant, kind in PLANT_SETTINGS.items() if key in _keys_of_plant(kind))
    return knowing or PLANTS


def _keys_of_plant(kind: type[Settings]) -> dict[str, Key]:
    """The keys that make up the settings `kind` of a plant: of the section `plant`, and of those that it holds."""
    keys = _section("plant", kind)
    for name, part in parts(kind).items():
        keys |= _section(name, part)
    return keys
