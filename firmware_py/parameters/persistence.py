"""Keeps the parameters: on flash across a loss of power, in retained memory across a watchdog reset in flight."""

from ..boards.interface import CAUSES, EVENT_MODE, EVENT_RESET, WATCHDOG
from ..generated_enums import KITE_MODE_STANDBY, MAV_SEVERITY_INFO, MAV_SEVERITY_WARNING
from .generated_parameters import COUNT, DEFAULTS
from .store import ParameterStore

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Final

    from ..boards.interface import Retained, Storage
    from ..modes.mode_machine import ModeMachine
    from .retained import EventRing, Recovery
    from .store import LoadReport
    from .values import Parameters

_SETTLE_US = 1000000  # type: Final  # flash is written when nothing has changed for so long: gains come one by one
_WRITES = 8  # type: Final  # to flash at once: a sector stands some 100,000, and a station may set things on and on
_WRITE_AGAIN_US = 60000000  # type: Final  # after them, one in this time
_STATIONS = 8  # type: Final  # ground stations that are told what happened at the start


class Keeper:
    """Loads at the start, then checks once per tick whether there is something to store.

    `storage` and `retained` are a board's (boards/interface.py); each may be None. Flash is never written while armed.
    """

    def __init__(
        self, parameters: "Parameters", modes: "ModeMachine", storage: "Storage | None", retained: "Retained | None",
        say: "Callable[[int, str], None]"
    ) -> None:
        self.store: "ParameterStore | None" = None if storage is None else ParameterStore(storage)
        self._recovery: "Recovery | None" = None
        self._events: "EventRing | None" = None
        if retained is not None:
            from .retained import EventRing, Recovery  # noqa: PLC0415  a PC has none, and needs the memory

            self._recovery = Recovery(retained)
            self._events = EventRing(retained)
        self._parameters = parameters
        self._modes = modes
        self._say = say
        self._report: list[tuple[int, str]] = []  # (severity, text): what happened at the start
        self._greeted: list[int] = []  # system ids of the ground stations that were told
        self._unsaved: bool = False
        self._version: int = -1  # of the parameters, when last kept
        self._armed: bool | None = None  # when last kept; None makes the first tick keep
        self._mode: int = modes.mode  # when last noted
        self.wrote: bool = False  # to flash, since somebody set this to False
        self._failed: bool = False
        self._quiet_us: int = 0  # since the last change
        self._writes_left: int = _WRITES
        self._earning_us: int = 0  # towards the next write
        self._told_spared: bool = False

    def start(self, reset_cause: str | None) -> None:
        """Load the parameters; after a watchdog reset in flight also fly on. None: there was no reset to tell of."""
        if reset_cause is not None:
            severity = MAV_SEVERITY_WARNING if reset_cause == WATCHDOG else MAV_SEVERITY_INFO
            self._report.append((severity, "reset: " + reset_cause))
            if self._events is not None:
                self._events.append(EVENT_RESET, CAUSES.index(reset_cause), 0)
        was_armed = self._recover() if reset_cause == WATCHDOG else None
        if was_armed is None:
            self._load()
        else:
            self._report.append((MAV_SEVERITY_WARNING, "parameters restored after the reset"))
            self._unsaved = self.store is not None
        for severity, text in self._report:
            self._say(severity, text)
        if was_armed:
            self._modes.recover()
        self._keep()  # at once: what an earlier flight left there must not be taken for this one

    def update(self, elapsed_us: int, uptime_us: int) -> None:
        """Store changes; `elapsed_us` since the last call. Almost free if nothing has changed."""
        mode = self._modes.mode
        if mode != self._mode:
            self._mode = mode
            if self._events is not None:
                self._events.append(EVENT_MODE, mode, uptime_us // 1000 & 0xFFFFFFFF)
        if self._writes_left < _WRITES:
            self._earning_us += elapsed_us
            if self._earning_us >= _WRITE_AGAIN_US:
                self._earning_us = 0
                self._writes_left += 1
        armed = mode != KITE_MODE_STANDBY
        version = self._parameters.version
        if version != self._version or armed != self._armed:
            if version != self._version:
                self._unsaved = self.store is not None
            self._quiet_us = 0
            self._armed = armed
            self._keep()
        elif self._unsaved and not armed:
            self._quiet_us += elapsed_us
            if self._quiet_us >= _SETTLE_US:
                self._quiet_us = 0
                self.save()

    def storage_fails(self) -> bool:
        """True if parameters could not be read at the start, or not saved the last time."""
        return self._failed

    def greet(self, system: int) -> None:
        """A ground station of this `system` id was heard: report once what happened at the start."""
        if system not in self._greeted and len(self._greeted) < _STATIONS:
            self._greeted.append(system)
            for severity, text in self._report:
                self._say(severity, text)

    def save(self) -> bool:
        """Write the parameters to flash; return False if that failed, is put off to spare it, or while armed."""
        if self.store is None or self._modes.armed():
            return False
        if self.store.holds(self._parameters):
            self._unsaved = False
            return True
        if not self._writes_left:
            self._unsaved = True
            if not self._told_spared:
                self._told_spared = True
                self._say(MAV_SEVERITY_WARNING, "saving parameters later to spare the flash")
            return False
        self._writes_left -= 1
        self._unsaved = self._told_spared = False
        self.wrote = True
        saved = self.store.save(self._parameters)
        self._failed = not saved
        if saved:
            self._say(MAV_SEVERITY_INFO, "parameters saved")
        else:
            self._say(MAV_SEVERITY_WARNING, "parameters not saved: storage failed")
        return saved

    def read_back(self) -> bool:
        """Take all parameters from flash, as at a start; return False if none are stored, or while armed."""
        if self.store is None or self._modes.armed():
            return False
        report = self.store.load(self._parameters)
        for severity, text in describe(report):
            self._say(severity, text)
        if report.found:
            self._unsaved = False
            self._keep()
        return report.found

    def reset(self) -> bool:
        """Set all parameters to their defaults, on flash too; return False if that failed, or while armed."""
        if self.store is None or self._modes.armed():
            return False
        for index in range(COUNT):
            self._parameters.set(index, DEFAULTS[index])
        self._keep()
        return self.save()

    def _keep(self) -> None:
        """Bring the retained memory up to date."""
        self._version = self._parameters.version
        if self._recovery is not None:
            self._recovery.write(self._parameters, self._modes.armed())

    def _recover(self) -> bool | None:
        """Take the parameters from retained memory; return whether the kite was armed, None where nothing is kept."""
        if self._recovery is None:
            return None
        was_armed = self._recovery.load(self._parameters)
        if was_armed is None:
            self._report.append((MAV_SEVERITY_WARNING, "nothing retained from before the reset"))
        return was_armed

    def _load(self) -> None:
        """Take the parameters from flash."""
        if self.store is not None:
            report = self.store.load(self._parameters)
            self._failed = report.damaged > 0 and not report.found
            self._report += describe(report)


def describe(report: "LoadReport") -> list[tuple[int, str]]:
    """A LoadReport as texts of at most 50 characters: (severity, text)."""
    texts: list[tuple[int, str]] = []
    if report.found:
        texts.append((MAV_SEVERITY_INFO, "%d parameters from storage" % report.loaded))
    else:
        texts.append((MAV_SEVERITY_INFO, "no parameters in storage"))
    if report.damaged:
        texts.append((MAV_SEVERITY_WARNING, "%d of 2 parameter slots damaged" % report.damaged))
    for names, what in (
        (report.unknown, "skipped, unknown here: "),
        (report.refused, "skipped, out of range: "),
        (report.missing, "not stored, at default: "),
    ):
        if names:
            text = what + names[0]
            if len(names) > 1:
                text += " +%d" % (len(names) - 1)
            texts.append((MAV_SEVERITY_WARNING, text))
    return texts
