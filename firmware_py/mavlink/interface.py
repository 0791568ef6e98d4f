"""What the firmware needs from a link, for the types alone: no board has this file."""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Protocol, TypeAlias

    from ..services.inbox import Inbox
    from .budget import LinkBudget

    # Of a message, in wire order: numbers, and bytes for text and data.
    Values: TypeAlias = Sequence[float | bytes | bytearray]

    Data: TypeAlias = bytes | bytearray | memoryview

    class Transport(Protocol):
        """Bytes in and out. It may have `bytes_per_s`, the capacity of its line, and what Peers has."""

        @property
        def datagrams(self) -> bool:
            """True where bytes arrive in whole datagrams."""
            ...

        def read(self) -> Data | None:
            """What has arrived, or None; valid until the next call."""
            ...

        def write(self, data: memoryview) -> object:
            """Send `data`; what cannot be sent is lost."""
            ...

    class Peers(Protocol):
        """A transport that others than the configured peer can send to."""

        @property
        def from_peer(self) -> bool:
            """True if the last bytes came from the configured peer."""
            ...

    class Link(Protocol):
        """Takes messages to ground stations and to the bridge, and brings theirs."""

        budget: LinkBudget
        lockstep: bool  # True where the bridge's ticks run the loop

        def set_system(self, system: int) -> None:
            """Be this system from now on."""
            ...

        def receive(self, inbox: Inbox, most: int = ...) -> int:
            """Put what has arrived into `inbox`, up to a lockstep tick; return the number of bytes read."""
            ...

        def send(self, message: int, values: Values) -> int:
            """Queue a message with `values` in wire order; return its size [bytes]."""
            ...

        def answer(self, message: int, values: Values) -> None:
            """Send an answer; the caller has claimed room with `budget.claim_answer_room`."""
            ...

        def flush(self) -> None:
            """Pass on what is queued."""
            ...

        def counters(self) -> tuple[int, int, int, int]:
            """(bad CRC, unusable here, lost by sequence number, bytes dropped), since start."""
            ...
