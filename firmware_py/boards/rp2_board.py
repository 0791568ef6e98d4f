"""Raspberry Pi Pico, Pico W and Pico 2 W."""

import sys
import time

import machine

from . import machine_board, rp2_memory
from .interface import POWER_ON, SOFT, WATCHDOG
from .retained_layout import Retained
from .settings import WIFI

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any, Final

    import network

    from .settings import Pin, Settings

LIGHT = "LED"  # type: Final
_IS_RP2350 = "RP2350" in sys.implementation._machine  # type: Final
# An RP2040 is rated for 200 MHz, and its ticks fit then; an RP2350 for 150 MHz, as MicroPython starts it.
_CLOCK_MHZ = 150 if _IS_RP2350 else 200  # type: Final
_MOST_AT_USUAL_VOLTAGE = 133  # type: Final  # [MHz]
_REGULATOR = 0x40064000  # type: Final
_VOLTAGE = 0xF0  # type: Final
_VOLTAGE_1_15 = 0xC0  # type: Final
_REGULATOR_US = 2000  # type: Final
_WATCHDOG_SCRATCH_4 = rp2_memory.SCRATCH + 0x10  # type: Final
_WATCHDOG_WAS_RUNNING = 0x6AB73121  # type: Final  # left by whoever starts it; machine.reset() leaves something else
_POWER_SAVE_OFF = 0xA11140  # type: Final  # the radio sleeps otherwise, and a datagram waits for up to 0.1 s


class Board(machine_board.MachineBoard):
    """A Pico with these `settings`; `tell(text)` writes to the console."""

    def __init__(self, settings: "Settings", tell: "Callable[[str], None]") -> None:
        self.reset_cause: str = reset_cause()
        set_clock(settings.cpu_mhz or _CLOCK_MHZ)
        wlan = _make_wlan() if settings.link == WIFI else None
        super().__init__(machine, time, settings, Retained(rp2_memory.BLOCK), wlan, tell)


def set_clock(mhz: int) -> None:
    """Run the processor at `mhz`. Beyond 133 MHz an RP2040 needs 1.15 V, which MicroPython 1.28 does not set."""
    if mhz * 1000000 == machine.freq():
        return
    if not _IS_RP2350 and mhz > _MOST_AT_USUAL_VOLTAGE:
        machine.mem32[_REGULATOR] = machine.mem32[_REGULATOR] & ~_VOLTAGE | _VOLTAGE_1_15
        time.sleep_us(_REGULATOR_US)
    machine.freq(mhz * 1000000)


def reset_cause() -> str:
    """Why the board started. machine.reset() also uses the watchdog's hardware, but is no watchdog reset."""
    if machine.reset_cause() != machine.WDT_RESET:
        return POWER_ON
    return WATCHDOG if machine.mem32[_WATCHDOG_SCRATCH_4] == _WATCHDOG_WAS_RUNNING else SOFT


def blink(pin: "Pin | None", pattern: int) -> "Any":
    """Show `pattern` on `pin` from now on."""
    return machine_board.blink(machine, time, -1, pin, pattern)


def _make_wlan() -> "network.WLAN":
    try:
        import network  # noqa: PLC0415  a plain Pico has none
    except ImportError:
        raise ValueError('LINK = "wifi": this board has no Wi-Fi, write "uart"') from None
    wlan = network.WLAN(network.STA_IF)
    wlan.active(True)
    wlan.config(pm=_POWER_SAVE_OFF)
    return wlan
