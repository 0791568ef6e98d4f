"""Raspberry Pi Pico, Pico W and Pico 2 W."""

import sys
import time

import machine
import uctypes

from . import machine_board
from .interface import POWER_ON, SOFT, WATCHDOG
from .settings import WIFI

LIGHT = "LED"
_IS_RP2350 = "RP2350" in sys.implementation._machine
# A bank of RAM for the second core's stack, which MicroPython leaves alone while no second thread runs.
_SCRATCH_X = 0x20080000 if _IS_RP2350 else 0x20040000
_RETAINED = _SCRATCH_X + 0x400
_RETAINED_BYTES = 512
_WATCHDOG_SCRATCH_4 = (0x400D8000 if _IS_RP2350 else 0x40058000) + 0x1C
_WATCHDOG_WAS_RUNNING = 0x6AB73121  # left there by whoever starts it; machine.reset() leaves something else
_POWER_SAVE_OFF = 0xA11140  # the radio sleeps otherwise, and a datagram waits for up to 0.1 s


class Retained:
    """Memory that survives a watchdog reset, but not a loss of power."""

    def __init__(self):
        self._memory = uctypes.bytearray_at(_RETAINED, _RETAINED_BYTES)

    def read(self):
        """All of it."""
        return bytes(self._memory)

    def write(self, data):
        """Put `data` at its beginning."""
        self._memory[: len(data)] = data


class Board(machine_board.MachineBoard):
    """A Pico with these `settings`; `tell(text)` writes to the console."""

    def __init__(self, settings, tell):
        self.reset_cause = reset_cause()
        wlan = _make_wlan() if settings.link == WIFI else None
        super().__init__(machine, time, settings, Retained(), wlan, tell)


def reset_cause():
    """Why the board started. machine.reset() also uses the watchdog's hardware, but is no watchdog reset."""
    if machine.reset_cause() != machine.WDT_RESET:
        return POWER_ON
    return WATCHDOG if machine.mem32[_WATCHDOG_SCRATCH_4] == _WATCHDOG_WAS_RUNNING else SOFT


def blink(pin, pattern):
    """Show `pattern` on `pin` from now on."""
    return machine_board.blink(machine, time, -1, pin, pattern)


def _make_wlan():
    try:
        import network  # noqa: PLC0415  a plain Pico has none
    except ImportError:
        raise ValueError('LINK = "wifi": this board has no Wi-Fi, write "uart"') from None
    wlan = network.WLAN(network.STA_IF)
    wlan.active(True)
    wlan.config(pm=_POWER_SAVE_OFF)
    return wlan
