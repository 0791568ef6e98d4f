"""The firmware's one link: MAVLink frames over a transport of bytes."""

from .generated_messages import HIL_ACTUATOR_CONTROLS, KITE_TICK_END
from .link_budget import LinkBudget
from .mavlink_decoder import Decoder
from .mavlink_encoder import LONGEST_FRAME, Encoder

_DATAGRAM = 1120  # frames are gathered until they pass this size [bytes]; one more still fits a network packet
_BYTES_AT_ONCE = 16384
_COMPONENT = 1  # MAV_COMP_ID_AUTOPILOT1


class MavlinkLink:
    """Moves messages between an inbox and a transport.

    The transport has `read() -> bytes or None`, `write(memoryview)`, and `datagrams`: True where bytes arrive in
    whole datagrams. A frame never spans two of them. It may have `bytes_per_s`, where its line carries no more.

    Steering and ends of ticks are numbered apart from all else, as a channel of their own: the bridge takes them
    off, and a ground station must not count them as lost.
    """

    def __init__(self, transport):
        self.decoder = Decoder()
        self.budget = LinkBudget(getattr(transport, "bytes_per_s", 0))
        self._encoder = Encoder(1, _COMPONENT)
        self._control_encoder = Encoder(1, _COMPONENT)
        self._transport = transport
        self._out = bytearray(_DATAGRAM + LONGEST_FRAME)
        self._out_view = memoryview(self._out)
        self._filled = 0

    def set_system(self, system):
        """Send with this system id from now on."""
        self._encoder.system = system
        self._control_encoder.system = system

    def receive(self, inbox, most=_BYTES_AT_ONCE):
        """Put what has arrived into `inbox`, up to a lockstep tick; return the bytes taken.

        Nothing more is read once `most` bytes were.
        """
        decoder = self.decoder
        whole = self._transport.datagrams
        taken = 0
        while taken < most:
            data = self._transport.read()
            if not data:
                break
            taken += len(data)
            decoder.feed(data)
            while decoder.next_frame(whole):
                inbox.put(decoder.message, decoder.values, decoder.system, decoder.component, decoder.sequence)
            if inbox.tick is not None:
                break
        return taken

    def send(self, message, values):
        """Queue a frame of `message` with `values` in wire order."""
        control = message in (HIL_ACTUATOR_CONTROLS, KITE_TICK_END)
        encoder = self._control_encoder if control else self._encoder
        before = self._filled
        self._filled = encoder.encode(self._out, before, message, values)
        self.budget.spend(self._filled - before)
        if self._filled > _DATAGRAM:
            self.flush()

    def flush(self):
        """Hand what is queued to the transport."""
        if self._filled:
            self._transport.write(self._out_view[: self._filled])
            self._filled = 0

    def counters(self):
        """(bad CRC, unknown message, lost by sequence number, bytes dropped), since start."""
        decoder = self.decoder
        return decoder.bad_crc, decoder.unknown, decoder.lost, decoder.overflowed
