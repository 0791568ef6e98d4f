"""What the control loop needs from a board, stand-ins for missing parts, and words that all boards share.

A board is any object with the attributes of Board; each is passed in, never imported by the loop.
"""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Final, Protocol, TypeAlias

    from ..mavlink.interface import Transport
    from ..sample import Sample

    Clock: TypeAlias = Callable[[], int]  # the time [us], wrapped at 2^30 (clock.py)

    class BoardTransport(Transport, Protocol):
        """The bytes of a board's link."""

        def wait(self, timeout_ms: int) -> bool:
            """Wait for something to arrive; False if nothing came within `timeout_ms`."""
            ...

    class Sensors(Protocol):
        """Sensors of the board's own."""

        def sample(self, now: int) -> Sample | None:
            """Values of KITE_SENSORS at `now` [us, wrapped], or None if there is nothing new."""
            ...

    class Actuator(Protocol):
        """What turns the steering into a position."""

        def write(self, steering: float, armed: bool) -> None:
            """Go to `steering`, -1 to 1; to neutral if not `armed`."""
            ...

    class Storage(Protocol):
        """A folder of small files; all raise OSError where it fails."""

        def read(self, name: str) -> bytes | None:
            """The content of file `name`, or None where there is no such file."""
            ...

        def write(self, name: str, data: bytes) -> None:
            """Write `data` to file `name`; on return it is stored."""
            ...

        def rename(self, old: str, new: str) -> None:
            """Rename file `old` to `new`, atomically replacing a file of that name."""
            ...

    class Retained(Protocol):
        """Memory that survives a watchdog reset but not a loss of power, laid out as in retained_layout.py."""

        def read(self, offset: int, size: int) -> bytes | bytearray:
            """`size` bytes from `offset` on."""
            ...

        def write(self, offset: int, data: bytes | bytearray) -> None:
            """Put `data` at `offset`."""
            ...

    class Watchdog(Protocol):
        """Resets a board whose loop hangs."""

        def feed(self) -> None:
            """The loop runs."""
            ...

    class Light(Protocol):
        """A status light."""

        def show(self, mode: int, stale: bool, now: int) -> None:
            """Show the state of the autopilot at `now` [us, wrapped]."""
            ...

    class Board(Protocol):
        """What the loop runs on."""

        @property
        def bytes_per_tick(self) -> int:
            """Maximum received in a tick: more would take too long."""
            ...

        @property
        def transport(self) -> BoardTransport:
            """The link's bytes."""
            ...

        @property
        def sensors(self) -> Sensors | None:
            """None if samples arrive over the link."""
            ...

        @property
        def actuator(self) -> Actuator | None:
            """None if steering only goes out over the link."""
            ...

        @property
        def storage(self) -> Storage | None:
            """None if nothing is stored."""
            ...

        @property
        def retained(self) -> Retained | None:
            """None if nothing outlives a reset."""
            ...

        @property
        def watchdog(self) -> Watchdog:
            """Fed after each tick."""
            ...

        @property
        def light(self) -> Light:
            """Shown after each tick."""
            ...

        @property
        def reset_cause(self) -> str:
            """One of CAUSES."""
            ...

        def ticks_us(self) -> int:
            """The clock [us], wrapped at 2^30 (clock.py)."""
            ...

        def ended(self) -> bool:
            """True when the loop should return; a real board never ends."""
            ...

POWER_ON = "power-on"  # type: Final
WATCHDOG = "watchdog"  # type: Final
SOFT = "soft"  # type: Final
CAUSES = (POWER_ON, WATCHDOG, SOFT)  # type: Final[tuple[str, ...]]

# What is noted in retained memory, with a value.
EVENT_RESET = 1  # type: Final  # the cause, by its place in CAUSES
EVENT_MODE = 2  # type: Final  # the new mode


class NoWatchdog:
    """For boards without a watchdog, and for the PC."""

    def feed(self) -> None:
        """No watchdog to feed."""


class NoLight:
    """For boards without a status light."""

    def show(self, mode: int, stale: bool, now: int) -> None:
        """No light to show it."""
