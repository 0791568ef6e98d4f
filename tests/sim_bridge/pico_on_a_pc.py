"""Boots an image as a Pico would, under MicroPython's unix port: run in the image's folder, with uart.in there.

Hardware is a UART whose bytes come from uart.in and go to uart.out; time passes when somebody sleeps or looks, and
Ctrl-C comes after ten seconds.
"""

import gc
import sys


class Clock:
    def __init__(self):
        self.now = 0

    def ticks_us(self):
        self.now += 7
        return self.now & 0x3FFFFFFF

    def sleep_us(self, duration_us):
        self.now += duration_us
        if self.now > 10000000:
            self.now = -1000000000
            raise KeyboardInterrupt

    def sleep(self, duration_s):
        self.sleep_us(int(duration_s * 1e6))


class Uart:
    def __init__(self, number, **settings):
        with open("uart.in", "rb") as file:  # noqa: PTH123  MicroPython has no pathlib
            self._incoming = file.read()
        self._out = open("uart.out", "wb")  # noqa: PTH123, SIM115

    def any(self):
        return len(self._incoming)

    def readinto(self, buffer):
        size = min(len(buffer), len(self._incoming))
        buffer[:size] = self._incoming[:size]
        self._incoming = self._incoming[size:]
        return size

    def write(self, data):
        self._out.write(data)
        self._out.flush()
        return len(data)


class Anything:
    OUT = IN = PULL_UP = PERIODIC = 0

    def __init__(self, *arguments, **settings):
        pass

    def __call__(self, level):
        pass

    def value(self):
        return 1

    def feed(self):
        pass


class Machine:
    UART = Uart
    Pin = Timer = WDT = Anything
    WDT_RESET = 3
    mem32 = {0x40064000: 0xB1, 0x4005800C: 0}  # noqa: RUF012  voltage regulator; holds nothing after power-on

    def freq(self, hz=125000000):
        return hz

    def reset_cause(self):
        return 1


class Uctypes:
    def addressof(self, block):
        return 0x20010000


sys.modules["machine"] = Machine()  # type: ignore[assignment]
sys.modules["uctypes"] = Uctypes()  # type: ignore[assignment]
sys.path.insert(0, "")
gc.threshold(8192)  # type: ignore[attr-defined]  as firmware_py/start.py does, before anything is loaded

from firmware_py.boards import rp2_memory  # noqa: E402, F401, I001  first, as firmware_py/start.py does
from firmware_py import startup  # noqa: E402
from firmware_py.boards import machine_board, rp2_board  # noqa: E402

rp2_board.time = startup.time = Clock()
machine_board.STORAGE_FOLDER = "kitepilot"
startup.start("rp2")
