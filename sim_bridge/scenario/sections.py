"""The settings that each part of a flight gets from a scenario."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any, NamedTuple, TypeVar

from kite_analysis.delay.whole_periods import split
from sim_bridge.equipment.actuator_settings import ActuatorSettings
from sim_bridge.equipment.error_settings import ErrorSettings, MeasurementErrors
from sim_bridge.equipment.sensor_settings import SensorSettings
from sim_bridge.links.ground_settings import GroundSettings
from sim_bridge.links.link_settings import LinkSettings, PathSettings
from sim_bridge.scenario.flight_settings import RunSettings, StartSettings
from sim_bridge.scenario.keys import PLANT_SETTINGS, PlantSettings
from sim_bridge.settings import Settings, own_keys, parts
from sim_bridge.wind.wind_settings import WindSettings

_Kind = TypeVar("_Kind", bound=Settings)


class Links(NamedTuple):
    """The emulated paths of a flight."""

    control: PathSettings
    ground: PathSettings


class Sections(ABC):
    """Values by dotted key, handed out as the settings of the parts; each access makes them of the present values."""

    def __init__(self, values: dict[str, Any]):
        self.values = values

    @abstractmethod
    def parameter(self, name: str) -> float:
        """Value of a firmware parameter."""

    @property
    def title(self) -> str:
        """One line about the scenario."""
        return self.values["title"]

    @property
    def plant_kind(self) -> str:
        """Which plant flies: a name in PLANTS."""
        return self.values["plant.kind"]

    @property
    def plant(self) -> PlantSettings:
        """Settings of the plant that flies, of that plant's own type."""
        return _assembled(PLANT_SETTINGS[self.plant_kind], "plant", self.values)

    @property
    def wind(self) -> WindSettings:
        """Settings of the wind."""
        return _assembled(WindSettings, "wind", self.values)

    @property
    def actuator(self) -> ActuatorSettings:
        """Settings of the steering actuator."""
        return _assembled(ActuatorSettings, "actuator", self.values)

    @property
    def sensors(self) -> SensorSettings:
        """Settings of the sensors."""
        return _assembled(SensorSettings, "sensors", self.values)

    @property
    def errors(self) -> MeasurementErrors:
        """What is wrong with each measured quantity."""
        return MeasurementErrors(*(
            _assembled(ErrorSettings, f"errors.{quantity}", self.values) for quantity in MeasurementErrors._fields))

    @property
    def link(self) -> Links:
        """Settings of both paths, direction by direction.

        A path's delay is halved; on the control path the half of the samples is rounded down to whole periods of the
        loop, which sees them only then, and the steering takes the rest.
        """
        down_s, up_s = split(self.values["link.control.delay_s"], 1.0 / self.parameter("LOOP_HZ"))
        half_s = self.values["link.ground.delay_s"] / 2
        return Links(self._path("control", down_s, up_s), self._path("ground", half_s, half_s))

    @property
    def ground(self) -> GroundSettings:
        """Where ground stations are."""
        return _assembled(GroundSettings, "ground", self.values)

    @property
    def start(self) -> StartSettings:
        """Where the flight starts."""
        return _assembled(StartSettings, "start", self.values)

    @property
    def run(self) -> RunSettings:
        """How long the flight is, what of it counts, and its seed."""
        return _assembled(RunSettings, "run", self.values)

    def _path(self, name: str, down_s: float, up_s: float) -> PathSettings:
        """The path `name`, whose directions have these delays [s] and what is set for both, where they have no own."""
        shared = {field: self.values[f"link.{name}.{field}"] for field in own_keys(LinkSettings)}
        directions = []
        for direction, delay_s in (("down", down_s), ("up", up_s)):
            alone = {field: self.values[f"link.{name}.{direction}.{field}"] for field in shared}
            own = {field: value for field, value in alone.items() if value is not None}
            directions.append(LinkSettings(**(shared | {"delay_s": delay_s} | own)))
        return PathSettings(*directions)


def _assembled(kind: type[_Kind], section: str, values: Mapping[str, Any]) -> _Kind:
    """Settings `kind`: its own fields from `section`, those of its parts from the sections of their names."""
    content = {name: values[f"{section}.{name}"] for name in own_keys(kind)}
    return kind(**content, **{name: _assembled(part, name, values) for name, part in parts(kind).items()})
