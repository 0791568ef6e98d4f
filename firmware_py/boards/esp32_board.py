"""ESP32 boards. This module compiles and is checked against the types; it has not flown, nor run on a board."""

import time

import machine
import network

from . import machine_board
from .interface import POWER_ON, SOFT, WATCHDOG
from .retained_layout import SIZE, Retained, take_over
from .settings import WIFI

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any, Final

    from .settings import Pin, Settings

LIGHT = 2  # type: Final
_TIMER = 0  # type: Final


def _retained() -> "Retained":
    """The RTC's memory, 2048 bytes in MicroPython's builds, which a reset by the watchdog leaves alone."""
    memory = machine.RTC().memory
    block = bytearray(SIZE)
    take_over(block, memory())
    return Retained(block, memory)


class Board(machine_board.MachineBoard):
    """An ESP32 with these `settings`; `tell(text)` writes to the console."""

    timer = _TIMER

    def __init__(self, settings: "Settings", tell: "Callable[[str], None]") -> None:
        self.reset_cause: str = reset_cause()
        wlan = _make_wlan() if settings.link == WIFI else None
        super().__init__(machine, time, settings, _retained(), wlan, tell)


def reset_cause() -> str:
    """Why the board started."""
    cause = machine.reset_cause()
    if cause == machine.WDT_RESET:
        return WATCHDOG
    return POWER_ON if cause == machine.PWRON_RESET else SOFT


def blink(pin: "Pin | None", pattern: int) -> "Any":
    """Show `pattern` on `pin` from now on."""
    return machine_board.blink(machine, time, _TIMER, pin, pattern)


def _make_wlan() -> "network.WLAN":
    wlan = network.WLAN(network.STA_IF)
    wlan.active(True)
    wlan.config(pm=network.WLAN.PM_NONE)
    return wlan
