"""Reads the settings in /board.py: every problem is one line that names the entry and says what would be right."""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any, Final, TypeAlias, TypedDict

    Pin: TypeAlias = int | str  # its number, or "LED"

    class Entry(TypedDict):
        """An encoder: its bus with the bus's pins, the raw reading at zero, and 1 or -1."""

        i2c: int
        sda: Pin
        scl: Pin
        zero: int
        direction: int

WIFI = "wifi"  # type: Final
UART = "uart"  # type: Final
HIL = "hil"  # type: Final
LINE_ANGLES = "line-angles"  # type: Final

_REQUIRED = object()  # type: Final
_PINS = {"rp2": 29, "esp32": 48}  # type: Final[dict[str, int]]  # the greatest pin number
_UARTS = {"rp2": (0, 1), "esp32": (1, 2)}  # type: Final[dict[str, tuple[int, int]]]  # an ESP32's 0 is the console
_LIGHTS = {"rp2": "LED", "esp32": 2}  # type: Final[dict[str, Pin]]
# What these processors are rated for.
_CLOCKS_MHZ = {"rp2": (100, 200), "esp32": (80, 240)}  # type: Final[dict[str, tuple[int, int]]]


class Settings:
    """The checked settings; entries that do not apply are as they are made here."""

    def __init__(self) -> None:
        self.link: str = ""
        self.ssid: str = ""  # with LINK "wifi", as the next two
        self.key: str = ""
        self.ground: tuple[str, int] = ("", 0)  # address, port
        self.uart: int = 0  # with LINK "uart", as the next three
        self.tx: "Pin" = 0
        self.rx: "Pin" = 0
        self.baud: int = 0
        self.system_id: int = 0
        self.sensors: str = ""
        self.azimuth: "Entry | None" = None  # with SENSORS "line-angles", as the next one
        self.elevation: "Entry | None" = None
        self.servo_pin: "Pin | None" = None
        self.servo_us: tuple[int, int, int] = (1000, 1500, 2000)  # pulses for steering -1, 0 and 1
        self.light_pin: "Pin | None" = None
        self.maintenance_pin: "Pin | None" = None
        self.cpu_mhz: int | None = None  # None: the board's own choice


def check_settings(values: "dict[str, Any]", platform: str) -> "tuple[Settings, list[str]]":
    """Return (Settings, problems) from `values`, entries by name; `platform` is sys.platform of the board."""
    reader = _Reader(values, platform)
    settings = Settings()
    settings.link = reader.take("LINK", '"wifi" or "uart"', lambda value: value in (WIFI, UART))
    if settings.link == WIFI:
        _read_wifi(reader, settings)
    elif settings.link == UART:
        _read_uart(reader, settings)
    settings.system_id = reader.number("SYSTEM_ID", 1, 250, 1)
    settings.sensors = reader.take("SENSORS", '"hil" or "line-angles"', lambda value: value in (HIL, LINE_ANGLES))
    if settings.sensors == LINE_ANGLES:
        _read_line_angles(reader, settings)
    _read_servo(reader, settings)
    settings.light_pin = reader.pin("LIGHT_PIN", _LIGHTS.get(platform))
    settings.maintenance_pin = reader.pin("MAINTENANCE_PIN", None)
    slowest, fastest = _CLOCKS_MHZ.get(platform, (1, 1000))
    settings.cpu_mhz = reader.number("CPU_MHZ", slowest, fastest, None)
    reader.look_for_strangers()
    return settings, reader.problems


def _read_wifi(reader: "_Reader", settings: "Settings") -> None:
    settings.ssid = reader.take("WIFI_SSID", "a name of 1 to 32 characters", lambda value: _is_text(value, 1, 32))
    right = 'a key of 8 to 63 characters, or "" for an open network'
    settings.key = reader.take("WIFI_KEY", right, lambda value: value == "" or _is_text(value, 8, 63))
    ground = reader.take("GROUND", 'as "192.168.1.10:14550"', lambda value: _address(value) is not None)
    address = _address(ground)
    if address is not None:
        settings.ground = address


def _read_uart(reader: "_Reader", settings: "Settings") -> None:
    first, last = _UARTS.get(reader.platform, (0, 1))
    settings.uart = reader.number("UART", first, last)
    settings.tx = reader.pin("UART_TX")
    settings.rx = reader.pin("UART_RX")
    settings.baud = reader.number("UART_BAUD", 9600, 3000000, 115200)


def _read_line_angles(reader: "_Reader", settings: "Settings") -> None:
    settings.azimuth = _read_encoder(reader, "AZIMUTH")
    settings.elevation = _read_encoder(reader, "ELEVATION")
    azimuth, elevation = settings.azimuth, settings.elevation
    if azimuth and elevation and azimuth["i2c"] == elevation["i2c"]:
        reader.problems.append('AZIMUTH and ELEVATION are on one bus, but share an address: write "i2c": 0 and 1')
    if reader.values.get("SERVO_PIN") is None:
        reader.problems.append("SERVO_PIN is missing: a kite with line-angles needs its servo's pin number")


def _read_encoder(reader: "_Reader", name: str) -> "Entry | None":
    """The dictionary of an encoder, each of its entries checked; None with problems told."""
    right = '{"i2c": 0, "sda": 4, "scl": 5, "zero": 0, "direction": 1}'
    entry = reader.take(name, right, lambda value: isinstance(value, dict))
    if entry is None:
        return None
    inner = _Reader(entry, reader.platform, name + " ", reader.pins)
    taken: "Entry" = {
        "i2c": inner.number("i2c", 0, 1),
        "sda": inner.pin("sda"),
        "scl": inner.pin("scl"),
        "zero": inner.number("zero", 0, 4095, 0),
        "direction": inner.take("direction", "1 or -1", lambda value: _is_whole(value, -1, 1) and value != 0, 1),
    }
    for key in entry:
        if key not in taken:
            inner.problems.append('%s"%s" is not known: there are i2c, sda, scl, zero, direction' % (name + " ", key))
    reader.problems.extend(inner.problems)
    return None if inner.problems else taken


def _read_servo(reader: "_Reader", settings: "Settings") -> None:
    settings.servo_pin = reader.pin("SERVO_PIN", None)
    minus = reader.number("SERVO_MINUS_US", 500, 2500, 1000)
    neutral = reader.number("SERVO_NEUTRAL_US", 500, 2500, 1500)
    plus = reader.number("SERVO_PLUS_US", 500, 2500, 2000)
    if minus is None or neutral is None or plus is None:
        return
    if not (minus < neutral < plus or minus > neutral > plus):
        reader.problems.append(
            "SERVO_NEUTRAL_US = %d is not between SERVO_MINUS_US = %d and SERVO_PLUS_US = %d" % (neutral, minus, plus)
        )
    settings.servo_us = (minus, neutral, plus)


class _Reader:
    """Takes entries out of `values` and writes down what is wrong with them."""

    def __init__(
        self, values: "dict[str, Any]", platform: str, prefix: str = "", pins: "dict[Pin, str] | None" = None
    ) -> None:
        self.values = values
        self.platform = platform
        self.problems: list[str] = []
        self.pins: "dict[Pin, str]" = {} if pins is None else pins  # who uses which
        self._prefix = prefix
        self._known: list[str] = []

    def take(self, name: str, right: str, is_good: "Callable[[Any], bool]", default: "Any" = _REQUIRED) -> "Any":
        """The entry `name`, or None and a problem if `is_good` rejects it; `right` says what would be valid."""
        self._known.append(name)
        value = self.values.get(name, default)
        if value is _REQUIRED:
            self.problems.append("%s%s is missing: write %s" % (self._prefix, name, right))
            return None
        if value is not default and not is_good(value):
            self.problems.append("%s%s = %s is wrong: write %s" % (self._prefix, name, _short(value), right))
            return None
        return value

    def number(self, name: str, least: int, greatest: int, default: "Any" = _REQUIRED) -> "Any":
        """A whole number."""
        right = "a whole number from %d to %d" % (least, greatest)
        return self.take(name, right, lambda value: _is_whole(value, least, greatest), default)

    def pin(self, name: str, default: "Any" = _REQUIRED) -> "Any":
        """A pin by its number, or "LED" if the board has that; each is used once. With a default, None is valid."""
        greatest = _PINS.get(self.platform, 48)
        right = "a pin number from 0 to %d" % greatest
        pin = self.take(name, right, lambda value: self._is_pin(value, greatest, default), default)
        if pin is not None:
            user = self._prefix + name
            if pin in self.pins:
                self.problems.append("%s and %s are both on pin %s: each needs its own" % (self.pins[pin], user, pin))
            self.pins[pin] = user
        return pin

    def _is_pin(self, value: "Any", greatest: int, default: "Any") -> bool:
        if value is None:
            return default is not _REQUIRED
        return _is_whole(value, 0, greatest) or value == "LED" == _LIGHTS.get(self.platform)

    def look_for_strangers(self) -> None:
        """Report unknown names in capitals, which are typing errors; settings of the other link are not."""
        for name in sorted(self.values):
            if name == name.upper() and not name.startswith("_") and name not in self._known and name not in _ENTRIES:
                self.problems.append("%s is not a setting: there are %s" % (name, ", ".join(_ENTRIES)))


_ENTRIES = (
    "LINK", "WIFI_SSID", "WIFI_KEY", "GROUND", "UART", "UART_TX", "UART_RX", "UART_BAUD", "SYSTEM_ID", "SENSORS",
    "AZIMUTH", "ELEVATION", "SERVO_PIN", "SERVO_MINUS_US", "SERVO_NEUTRAL_US", "SERVO_PLUS_US", "LIGHT_PIN",
    "MAINTENANCE_PIN", "CPU_MHZ",
)  # type: Final[tuple[str, ...]]


def _is_whole(value: "Any", least: int, greatest: int) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and least <= value <= greatest


def _is_text(value: "Any", least: int, greatest: int) -> bool:
    return isinstance(value, str) and least <= len(value) <= greatest


def _address(value: "Any") -> tuple[str, int] | None:
    """("192.168.1.10", 14550) from "192.168.1.10:14550", or None. Numbers only: a board may have no name server."""
    if not isinstance(value, str) or value.count(":") != 1:
        return None
    host, port = value.split(":")
    parts = host.split(".")
    if len(parts) != 4 or not _is_digits(port, 65535) or port == "0":
        return None
    for part in parts:
        if not _is_digits(part, 255):
            return None
    return host, int(port)


def _is_digits(text: str, greatest: int) -> bool:
    return text.isdigit() and len(text) < 6 and int(text) <= greatest


def _short(value: "Any") -> str:
    text = repr(value)
    return text if len(text) <= 40 else text[:37] + "..."
