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
from .settings import LINE_ANGLES, WIFI

STORAGE_FOLDER = "/kitepilot"
_BUFFER = 2048  # of the UART, each way: a tick's frames, and a burst of requests [bytes]
_BYTES_PER_TICK = 2048  # seven long frames in 0.64 ms, with the checksum in native code: some 5 ms of a tick
_I2C_HZ = 400000
_I2C_TIMEOUT_US = 1000  # a read takes 160; an encoder that holds the bus costs a tick twice this, not the flight
_BLINK_MS = 60

# A save to flash stalls a board for 0.1 s, joining a network for some tenths; a kite flies 30 deg in a second.
WATCHDOG_MS = 1000


class MachineBoard:
    """A board, as boards/interface.py describes it.

    `machine` and `time` are MicroPython's modules, or stand-ins. `wlan` is the network interface, made active, or None.
    """

    timer = -1  # a software timer, where there are any
    bytes_per_tick = _BYTES_PER_TICK

    def __init__(self, machine, time, settings, retained, wlan, tell):
        self._machine = machine
        self._time = time
        self._settings = settings
        self._timer = None
        self.retained = retained
        self.actuator = make_servo(machine, settings)  # first: the servo goes to neutral
        self.transport = self._make_transport(wlan, tell)
        self.sensors = make_sensors(machine, settings)
        self.storage = FileStorage(STORAGE_FOLDER)
        self.watchdog = NoWatchdog()
        transport = self.transport
        self.light = StatusLight(make_light_pin(machine, settings.light_pin), lambda: transport.received)

    def ticks_us(self):
        """The board's clock in the firmware's wrap."""
        return self._time.ticks_us() & MASK

    def ended(self):
        """Never."""
        return False

    def start_watchdog(self):
        """From here on a loop that hangs for WATCHDOG_MS resets the board; this cannot be undone."""
        self.watchdog = self._machine.WDT(timeout=WATCHDOG_MS)

    def is_watched(self):
        """True once the watchdog runs."""
        return not isinstance(self.watchdog, NoWatchdog)

    def wants_maintenance(self):
        """True while the maintenance pin is grounded."""
        pin = self._settings.maintenance_pin
        if pin is None:
            return False
        machine = self._machine
        return not machine.Pin(pin, machine.Pin.IN, machine.Pin.PULL_UP).value()

    def stop(self, pattern):
        """Stop steering but stay reachable: servo neutral, no flight to resume, watchdog fed, `pattern` shown."""
        if self.actuator is not None:
            self.actuator.write(0.0, False)
        self.retained.write(FLIGHT, bytes(FLIGHT_BYTES))
        watchdog = self.watchdog
        light = self.light
        light.ask_storage(None)  # the autopilot's memory is free for what is typed at the console

        def keep(timer):
            watchdog.feed()
            light.show_pattern(pattern, self.ticks_us())

        self._timer = self._every(_BLINK_MS, keep)

    def _every(self, period_ms, call):
        machine = self._machine
        return machine.Timer(self.timer, period=period_ms, mode=machine.Timer.PERIODIC, callback=call)

    def _make_transport(self, wlan, tell):
        settings = self._settings
        if settings.link == WIFI:
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


def make_servo(machine, settings):
    """The servo at neutral, or None if there is none."""
    if settings.servo_pin is None:
        return None
    pwm = machine.PWM(machine.Pin(settings.servo_pin), freq=1000000 // PERIOD_US, duty_u16=0)
    minus_us, neutral_us, plus_us = settings.servo_us
    return Servo(pwm, minus_us, neutral_us, plus_us)


def make_encoder(machine, entry):
    """The encoder of a settings entry."""
    sda = machine.Pin(entry["sda"])
    scl = machine.Pin(entry["scl"])
    return As5600(machine.I2C(entry["i2c"], sda=sda, scl=scl, freq=_I2C_HZ, timeout=_I2C_TIMEOUT_US))


def make_sensors(machine, settings):
    """The line's encoders, or None where samples arrive over the link."""
    if settings.sensors != LINE_ANGLES:
        return None
    return LineAngles(_make_axis(machine, settings.azimuth), _make_axis(machine, settings.elevation))


def _make_axis(machine, entry):
    return Axis(make_encoder(machine, entry), entry["zero"], entry["direction"])


def make_light_pin(machine, pin):
    """A callable for StatusLight."""
    return _dark if pin is None else machine.Pin(pin, machine.Pin.OUT)


def blink(machine, time, timer, pin, pattern):
    """Show `pattern` from now on, without a board; returns the timer."""
    light = StatusLight(make_light_pin(machine, pin))
    return machine.Timer(
        timer, period=_BLINK_MS, mode=machine.Timer.PERIODIC,
        callback=lambda timer: light.show_pattern(pattern, time.ticks_us() & MASK),
    )


def _dark(value):
    """A light that is not there."""
