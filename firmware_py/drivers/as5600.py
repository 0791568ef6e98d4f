"""The AS5600 magnetic encoder: 4096 steps a turn, over I2C.

Its address is fixed, so each encoder needs its own I2C bus.
"""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Final

    from .interface import I2c

ADDRESS = 0x36  # type: Final
STEPS = 4096  # type: Final
_STATUS = 0x0B  # type: Final  # the raw angle, high byte first, is in the two registers behind it
_TOO_STRONG = 0x08  # type: Final
_TOO_WEAK = 0x10  # type: Final
_DETECTED = 0x20  # type: Final


class As5600:
    """One encoder on `i2c`, an object with `readfrom_mem_into(address, register, buffer)`."""

    def __init__(self, i2c: "I2c") -> None:
        self._i2c = i2c
        self._buffer: bytearray = bytearray(3)
        self.raw: int = 0  # 0 to 4095, as read last
        self.magnet: int = 0  # bits of the status register, as read last

    def read(self) -> bool:
        """Read status and raw angle in one transfer; False if the encoder does not answer."""
        try:
            self._i2c.readfrom_mem_into(ADDRESS, _STATUS, self._buffer)
        except OSError:
            return False
        self.magnet, high, low = self._buffer
        self.raw = (high << 8 | low) & 0xFFF
        return True

    def has_magnet(self) -> bool:
        """True if a magnet was detected at the last reading; without one the angle is meaningless."""
        return bool(self.magnet & _DETECTED)

    def magnet_advice(self) -> str:
        """Advice on the magnet's position from the last reading; empty if it is right."""
        if not self.magnet & _DETECTED:
            return "no magnet"
        if self.magnet & _TOO_WEAK:
            return "magnet weak: move it closer"
        return "magnet strong: move it away" if self.magnet & _TOO_STRONG else ""
