"""The firmware's one link: MAVLink frames over a transport of bytes."""

from ..generated_enums import MAV_COMP_ID_AUTOPILOT1, MAV_COMP_ID_USER1, MAV_COMP_ID_USER2
from .budget import LinkBudget
from .decoder import Decoder
from .encoder import LONGEST_FRAME, Encoder
from .generated_messages import HIL_ACTUATOR_CONTROLS, KITE_SENSORS, KITE_STATE, KITE_TICK, KITE_TICK_END

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Final

    from ..services.inbox import Inbox
    from .interface import Peers, Transport, Values

_DATAGRAM = 1120  # type: Final  # frames are gathered until they pass it [bytes]; one more still fits a network packet
_BYTES_AT_ONCE = 16384  # type: Final


class MavlinkLink:
    """Moves messages between an inbox and a transport.

    The transport has `read() -> bytes or None`, `write(memoryview)`, and `datagrams`: True where bytes arrive in
    whole datagrams. A frame never spans two of them. It may have `bytes_per_s`, the capacity of its line, and
    `from_peer`: False if the last bytes did not come from the configured peer. Samples and ticks
    of a bridge are taken from that peer only, and ticks only in `lockstep`.

    Three components number their frames separately, because ground stations count losses by component: the autopilot
    itself; 25, whose KITE_STATE most ground stations do not know; 26, whose frames the bridge removes.
    """

    def __init__(self, transport: "Transport") -> None:
        self.decoder = Decoder()
        self.decoder.own_component = MAV_COMP_ID_AUTOPILOT1
        self.budget = LinkBudget(getattr(transport, "bytes_per_s", 0))
        self.refused: int = 0  # samples and ticks of others than the peer, ticks in real time
        self._encoder = Encoder(1, MAV_COMP_ID_AUTOPILOT1)
        self._own_encoder = Encoder(1, MAV_COMP_ID_USER1)
        self._control_encoder = Encoder(1, MAV_COMP_ID_USER2)
        self.lockstep: bool = False  # true where the bridge's ticks run the loop
        self._transport = transport
        whose: "Any" = transport
        self._peers: "Peers | None" = whose if hasattr(transport, "from_peer") else None
        self._out: bytearray = bytearray(_DATAGRAM + LONGEST_FRAME)
        self._out_view: memoryview = memoryview(self._out)
        self._filled: int = 0
        self.set_system(1)

    def set_system(self, system: int) -> None:
        """Be this system from now on."""
        self.decoder.own_system = system
        for encoder in (self._encoder, self._own_encoder, self._control_encoder):
            encoder.system = system

    def receive(self, inbox: "Inbox", most: int = _BYTES_AT_ONCE) -> int:
        """Put messages for this system into `inbox`, up to a lockstep tick; return the number of bytes read.

        Reading stops after `most` bytes.
        """
        decoder = self.decoder
        transport = self._transport
        peers = self._peers
        whole = transport.datagrams
        taken = 0
        while taken < most:
            data = transport.read()
            if not data:
                break
            taken += len(data)
            decoder.feed(data)
            while decoder.next_frame(whole):
                message = decoder.message
                if message in (KITE_SENSORS, KITE_TICK) and (
                    (peers is not None and not peers.from_peer) or (message == KITE_TICK and not self.lockstep)
                ):
                    self.refused += 1  # it came from where it may not come, or is of no use
                else:
                    inbox.put(message, decoder.values, decoder.system, decoder.component, decoder.sequence)
            if inbox.tick is not None:
                break
        return taken

    def send(self, message: int, values: "Values") -> int:
        """Queue a frame of `message` with `values` in wire order; return its size [bytes]."""
        if message in (HIL_ACTUATOR_CONTROLS, KITE_TICK_END):
            encoder = self._control_encoder
        else:
            encoder = self._own_encoder if message == KITE_STATE else self._encoder
        before = self._filled
        self._filled = encoder.encode(self._out, before, message, values)
        size = self._filled - before
        self.budget.spend(size)
        if self._filled > _DATAGRAM:
            self.flush()
        return size

    def answer(self, message: int, values: "Values") -> None:
        """Send an answer; the caller has claimed room with `budget.claim_answer_room`."""
        self.budget.spend_on_answer(self.send(message, values))

    def flush(self) -> None:
        """Pass the queued bytes to the transport."""
        if self._filled:
            self._transport.write(self._out_view[: self._filled])
            self._filled = 0

    def counters(self) -> tuple[int, int, int, int]:
        """(bad CRC, unusable here, lost by sequence number, bytes dropped), since start.

        Unusable are unknown messages, those for others, and samples and ticks from other peers.
        """
        decoder = self.decoder
        unknown = decoder.unknown + decoder.foreign + self.refused
        return decoder.bad_crc, unknown, decoder.lost, decoder.overflowed
