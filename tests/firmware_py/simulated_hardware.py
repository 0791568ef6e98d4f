"""A board's hardware, simulated: what MicroPython's `machine` has, as far as the firmware uses it."""

from collections import defaultdict
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

MAGNET = 0x20
WEAK = 0x10
STRONG = 0x08


class SimulatedEncoder:
    """An AS5600: its registers, and its address pointer, which stays where a read of the raw angle began."""

    def __init__(self, raw: int = 0, status: int = MAGNET):
        self.raw = raw
        self.status = status

    def register(self, address: int) -> int:
        raw = self.raw & 0xFFF
        return {0x0B: self.status, 0x0C: raw >> 8, 0x0D: raw & 0xFF}.get(address, 0)

    def read(self, register: int, size: int) -> bytes:
        if register == 0x0C:  # re-reads the two bytes of the angle, says the data sheet
            return bytes(self.register(0x0C + index % 2) for index in range(size))
        return bytes(self.register(register + index) for index in range(size))


class SimulatedI2C:
    """A bus with devices by their address; `broken` makes every transfer fail."""

    def __init__(self, **devices: SimulatedEncoder):
        self.devices: dict[int, SimulatedEncoder] = {int(name[1:], 16): device for name, device in devices.items()}
        self.broken = False
        self.transfers = 0

    def readfrom_mem_into(self, address: int, register: int, buffer: bytearray) -> None:
        self.transfers += 1
        if self.broken or address not in self.devices:
            raise OSError(5, "EIO")
        buffer[:] = self.devices[address].read(register, len(buffer))


def encoder_bus(raw: int = 0, status: int = MAGNET) -> tuple[SimulatedEncoder, SimulatedI2C]:
    encoder = SimulatedEncoder(raw, status)
    return encoder, SimulatedI2C(x36=encoder)


class SimulatedPwm:
    """A PWM output at 50 Hz; remembers every pulse [us] that it was told to give."""

    def __init__(self, pin: Any = None, freq: int = 50, duty_u16: int = 0):
        self.pulses: list[float] = []
        self.freq = freq

    def duty_ns(self, duration_ns: int) -> None:
        assert isinstance(duration_ns, int)
        self.pulses.append(duration_ns / 1000)

    def duty_u16(self, share: int) -> None:
        raise AssertionError("duty_ns is finer")


class CoarsePwm:
    """One that only knows shares of the period, as some ports do."""

    def __init__(self) -> None:
        self.pulses: list[float] = []

    def duty_u16(self, share: int) -> None:
        assert isinstance(share, int)
        self.pulses.append(share * 20000 / 65535)


class SimulatedPin:
    IN, OUT, PULL_UP = 0, 1, 2

    def __init__(self, number: Any, mode: int = -1, pull: int = -1):
        self.number = number
        self.levels: list[int] = []
        self.level = 1

    def __call__(self, level: int) -> None:
        self.levels.append(level)

    def value(self) -> int:
        return self.level


class SimulatedUart:
    """Bytes in `incoming` are there to be read; `room` is how much can be written at once."""

    def __init__(self, number: int = 0, **settings: Any):
        self.number = number
        self.settings = settings
        self.incoming = bytearray()
        self.outgoing = bytearray()
        self.room = 1 << 30

    def any(self) -> int:
        return len(self.incoming)

    def readinto(self, buffer: memoryview) -> int | None:
        size = min(len(buffer), len(self.incoming))
        buffer[:size] = self.incoming[:size]
        del self.incoming[:size]
        return size or None

    def write(self, data: Any) -> int | None:
        size = min(self.room, len(data))
        self.outgoing += bytes(data[:size])
        return size or None


class SimulatedClock:
    """Time that passes when somebody sleeps, or looks; `on_sleep` is called with the new time [us] after a sleep."""

    def __init__(self, start_us: int = 0, look_us: int = 0):
        self.now = start_us
        self._look_us = look_us
        self.on_sleep: Callable[[int], None] = lambda now: None

    def ticks_us(self) -> int:
        self.now += self._look_us
        return self.now & 0x3FFFFFFF

    def sleep_us(self, duration_us: int) -> None:
        self.now += duration_us
        self.on_sleep(self.now)

    def sleep(self, duration_s: float) -> None:
        self.sleep_us(round(duration_s * 1e6))


class SimulatedTimer:
    PERIODIC = 1

    def __init__(self, number: int, period: int, mode: int, callback: Callable[[Any], None]):
        self.number = number
        self.period = period
        self.call = callback


class SimulatedWatchdog:
    def __init__(self, timeout: int):
        self.timeout = timeout
        self.fed = 0

    def feed(self) -> None:
        self.fed += 1


class SimulatedMachine(SimpleNamespace):
    """The module `machine`. What is made of it is kept in `made`, by kind, oldest first."""

    PWRON_RESET, WDT_RESET = 1, 3

    def __init__(self, buses: dict[int, SimulatedI2C] | None = None):
        super().__init__()
        self.made: dict[str, list[Any]] = {}
        self.buses = buses or {}
        self.mem32: dict[int, int] = defaultdict(int)
        self.clock_hz = 125_000_000
        self.cause = self.PWRON_RESET
        self.grounded: set[Any] = set()
        for name, kind in (("PWM", SimulatedPwm), ("UART", SimulatedUart), ("Timer", SimulatedTimer),
                           ("WDT", SimulatedWatchdog), ("Pin", SimulatedPin)):
            setattr(self, name, self._maker(name, kind))

    def reset_cause(self) -> int:
        return self.cause

    def freq(self, hz: int | None = None) -> int | None:
        if hz is None:
            return self.clock_hz
        self.clock_hz = hz
        return None

    def I2C(self, number: int, **settings: Any) -> SimulatedI2C:  # noqa: N802  the module's own name
        return self.buses.setdefault(number, SimulatedI2C())

    def _maker(self, name: str, kind: Any) -> Any:
        def make(*arguments: Any, **settings: Any) -> Any:
            made = kind(*arguments, **settings)
            if name == "Pin":
                made.level = 0 if made.number in self.grounded else 1
            self.made.setdefault(name, []).append(made)
            return made

        for constant in ("IN", "OUT", "PULL_UP", "PERIODIC"):
            if hasattr(kind, constant):
                setattr(make, constant, getattr(kind, constant))
        return make
