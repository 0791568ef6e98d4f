"""Raspberry Pi Pico, Pico W and Pico 2 W."""

import time

import machine

from . import machine_board, rp2_memory
from .interface import POWER_ON, SOFT, WATCHDOG
from .retained_layout import Retained
from .settings import WIFI

LIGHT = "LED"
_WATCHDOG_SCRATCH_4 = rp2_memory.SCRATCH + 0x10
_WATCHDOG_WAS_RUNNING = 0x6AB73121  # left there by whoever starts it; machine.reset() leaves something else
_POWER_SAVE_OFF = 0xA11140  # the radio sleeps otherwise, and a datagram waits for up to 0.1 s


class Board(machine_board.MachineBoard):
    """A Pico with these `settings`; `tell(text)` writes to the console."""

    def __init__(self, settings, tell):
        self.reset_cause = reset_cause()
        wlan = _make_wlan() if settings.link == WIFI else None
        super().__init__(machine, time, settings, Retained(rp2_memory.BLOCK), wlan, tell)


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
