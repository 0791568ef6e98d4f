"""What boards with a `machine` module share; the module, its clock and the network are passed in.

The board modules (rp2_board.py, esp32_board.py) add what differs: retained memory, the cause of a reset, names.
"""

from ..boards.file_storage import FileStorage
from ..clock import MASK
from ..drivers.as5600 import As5600
from ..drivers.line_angles import Axis, LineAngles
from ..drivers.servo import PERIOD_US, Servo
from .interface import NoWatchdog
from .light import StatusLight
from .retained_layout import FLIGHT, FLIGHT_BYTES

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any, Final

    from ..transports.interface import Wlan
    from ..transports.uart import UartTransport
    from ..transports.wifi import WifiTransport
    from .interface import Retained, Watchdog
    from .settings import Entry, Pin, Settings

STORAGE_FOLDER = "/kitepilot"  # type: Final
_BUFFER = 2048  # type: Final  # of the UART, each way: a tick's frames, and a burst of requests [bytes]
# Seven long frames in 0.64 ms, with the checksum in native code: some 5 ms of a tick.
_BYTES_PER_TICK = 2048  # type: Final
_I2C_HZ = 400000  # type: Final
# A read takes 160 us; an encoder that holds the bus costs a tick twice this, not the flight.
_I2C_TIMEOUT_US = 1000  # type: Final
_BLINK_MS = 60  # type: Final

# A save to flash stalls a board for 0.1 s, joining a network for some tenths; a kite flies 30 deg in a second.
WATCHDOG_MS = 1000  # type: Final


class MachineBoard:
    """A board, as boards/interface.py describes it.

    `machine` and `time` are MicroPython's modules, or stand-ins. `wlan` is the network interface, made active, or None.
    """

    timer = -1  # a software timer, where there are any
    bytes_per_tick = _BYTES_PER_TICK
    reset_cause: str

    def __init__(
        self, machine: "Any", time: "Any", settings: "Settings", retained: "Retained", wlan: "Wlan | None",
        tell: "Callable[[str], None]"
    ) -> None:
        self._machine = machine
        self._time = time
        self._settings = settings
        self._timer: "Any" = None
        self.retained = retained
        self.actuator: "Servo | None" = make_servo(machine, settings)  # first: the servo goes to neutral
        self.transport: "WifiTransport | UartTransport" = self._make_transport(wlan, tell)
        self.sensors: "LineAngles | None" = make_sensors(machine, settings)
        self.storage = FileStorage(STORAGE_FOLDER)
        self.watchdog: "Watchdog" = NoWatchdog()
        transport = self.transport
        self.light = StatusLight(make_light_pin(machine, settings.light_pin), lambda: transport.received)

    def ticks_us(self) -> int:
        """The board's clock in the firmware's wrap."""
        return self._time.ticks_us() & MASK

    def ended(self) -> bool:
        """Never."""
        return False

    def start_watchdog(self) -> None:
        """From here on a loop that hangs for WATCHDOG_MS resets the board; this cannot be undone."""
        self.watchdog = self._machine.WDT(timeout=WATCHDOG_MS)

    def is_watched(self) -> bool:
        """True once the watchdog runs."""
        return not isinstance(self.watchdog, NoWatchdog)

    def wants_maintenance(self) -> bool:
        """True while the maintenance pin is grounded."""
        pin = self._settings.maintenance_pin
        if pin is None:
            return False
        machine = self._machine
        return not machine.Pin(pin, machine.Pin.IN, machine.Pin.PULL_UP).value()

    def stop(self, pattern: int) -> None:
        """Stop steering but stay reachable: servo neutral, no flight to resume, watchdog fed, `pattern` shown."""
        if self.actuator is not None:
            self.actuator.write(0.0, False)
        self.retained.write(FLIGHT, bytes(FLIGHT_BYTES))
        watchdog = self.watchdog
        light = self.light
        light.ask_storage(None)  # the autopilot's memory is free for what is typed at the console

        def keep(timer: "Any") -> None:
            watchdog.feed()
            light.show_pattern(pattern, self.ticks_us())

        self._timer = self._every(_BLINK_MS, keep)

    def _every(self, period_ms: int, call: "Callable[[Any], None]") -> "Any":
        machine = self._machine
        return machine.Timer(self.timer, period=period_ms, mode=machine.Timer.PERIODIC, callback=call)

    def _make_transport(self, wlan: "Wlan | None", tell: "Callable[[str], None]") -> "WifiTransport | UartTransport":
        settings = self._settings
        if wlan is not None:
            from ..transports.udp import UdpStations  # noqa: PLC0415  a board without Wi-Fi has no `socket`
            from ..transports.wifi import WifiTransport  # noqa: PLC0415

            host, port = settings.ground
            udp = UdpStations(host, port, self.ticks_us)
            return WifiTransport(wlan, settings.ssid, settings.key, udp, self.ticks_us, tell)
        from ..transports.uart import UartTransport  # noqa: PLC0415  only one of the two takes memory

        machine = self._machine
        uart = machine.UART(
            settings.uart, baudrate=settings.baud, tx=machine.Pin(settings.tx), rx=machine.Pin(settings.rx),
            txbuf=_BUFFER, rxbuf=_BUFFER, timeout=0,
        )
        return UartTransport(uart, self.ticks_us, self._time.sleep_us, settings.baud // 10)


def make_servo(machine: "Any", settings: "Settings") -> "Servo | None":
    """The servo at neutral, or None if there is none."""
    if settings.servo_pin is None:
        return None
    pwm = machine.PWM(machine.Pin(settings.servo_pin), freq=1000000 // PERIOD_US, duty_u16=0)
    minus_us, neutral_us, plus_us = settings.servo_us
    return Servo(pwm, minus_us, neutral_us, plus_us)


def make_encoder(machine: "Any", entry: "Entry") -> "As5600":
    """The encoder of a settings entry."""
    sda = machine.Pin(entry["sda"])
    scl = machine.Pin(entry["scl"])
    return As5600(machine.I2C(entry["i2c"], sda=sda, scl=scl, freq=_I2C_HZ, timeout=_I2C_TIMEOUT_US))


def make_sensors(machine: "Any", settings: "Settings") -> "LineAngles | None":
    """The line's encoders, or None where samples arrive over the link."""
    azimuth, elevation = settings.azimuth, settings.elevation
    if azimuth is None or elevation is None:
        return None
    return LineAngles(_make_axis(machine, azimuth), _make_axis(machine, elevation))


def _make_axis(machine: "Any", entry: "Entry") -> "Axis":
    return Axis(make_encoder(machine, entry), entry["zero"], entry["direction"])


def make_light_pin(machine: "Any", pin: "Pin | None") -> "Callable[[int], object]":
    """A callable for StatusLight."""
    return _dark if pin is None else machine.Pin(pin, machine.Pin.OUT)


def blink(machine: "Any", time: "Any", timer: int, pin: "Pin | None", pattern: int) -> "Any":
    """Show `pattern` from now on, without a board; returns the timer."""
    light = StatusLight(make_light_pin(machine, pin))

    def show(timer: "Any") -> None:
        light.show_pattern(pattern, time.ticks_us() & MASK)

    return machine.Timer(timer, period=_BLINK_MS, mode=machine.Timer.PERIODIC, callback=show)


def _dark(value: int) -> None:
    """A light that is not there."""
