"""What the drivers need of a board's pins, for the types alone: no board has this file."""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Protocol

    class I2c(Protocol):
        """A bus, as MicroPython's machine.I2C."""

        def readfrom_mem_into(self, __address: int, __register: int, __buffer: bytearray) -> object:
            """Fill the buffer from a register of a device on; OSError if that fails."""
            ...

    class Pwm(Protocol):
        """An output, as MicroPython's machine.PWM. Where it also has `duty_ns(ns)`, that is taken: it is finer."""

        def duty_u16(self, __share: int) -> object:
            """Be high for so many 65535ths of the period."""
            ...
