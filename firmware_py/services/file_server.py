"""Serves the parameter metadata by MAVLink's file transfer (FILE_TRANSFER_PROTOCOL), and refuses everything else.

A station has one session, number 0: some (mavsdk 4.1.0) say 0 whatever number they were given. Nothing is kept of a
station but the file that it opened last and where its burst has come to, so that requests may be repeated, also after
the session's end, and stations do not disturb each other. https://mavlink.io/en/services/ftp.html
"""

import struct

from ..generated_enums import (
    MAV_FTP_ERR_EOF,
    MAV_FTP_ERR_FILENOTFOUND,
    MAV_FTP_ERR_INVALIDSESSION,
    MAV_FTP_ERR_UNKNOWNCOMMAND,
    MAV_FTP_OPCODE_ACK,
    MAV_FTP_OPCODE_BURSTREADFILE,
    MAV_FTP_OPCODE_CALCFILECRC,
    MAV_FTP_OPCODE_NAK,
    MAV_FTP_OPCODE_NONE,
    MAV_FTP_OPCODE_OPENFILERO,
    MAV_FTP_OPCODE_READFILE,
    MAV_FTP_OPCODE_RESETSESSION,
    MAV_FTP_OPCODE_TERMINATESESSION,
)
from ..mavlink.generated_messages import FILE_TRANSFER_PROTOCOL
from .generated_metadata import CRC32S, NAMES, SIZES

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from io import BufferedReader
    from typing import Any, Final

    from ..mavlink.interface import Link

_HEADER = "<HBBBBBBI"  # type: Final  # sequence, session, opcode, size, opcode asked, burst complete, padding, offset
_DATA = 12  # type: Final  # where the data begin
_MOST = 239  # type: Final  # bytes of data in a message
_AROUND = 27  # type: Final  # bytes of a frame that are no data
_LEAST = 32  # type: Final  # bytes of data, on the slowest line
_BURSTS = 4  # type: Final  # stations served at a time
_STATIONS = 8  # type: Final  # whose sessions are kept


class _Burst:
    """A file on its way to a station, `piece` bytes at a time; `index` is that of the file."""

    def __init__(self, system: int, component: int, sequence: int, index: int, offset: int, piece: int) -> None:
        self.system = system
        self.component = component
        self.sequence = sequence
        self.index = index
        self.offset = offset
        self.piece = piece


class FileServer:
    """One message a tick: an answer, or else the next piece of a burst."""

    def __init__(self, link: "Link") -> None:
        self._link = link
        self._payload: bytearray = bytearray(_DATA + _MOST)
        self._view: memoryview = memoryview(self._payload)
        self._zeros: bytes = bytes(_MOST)
        self._file: "BufferedReader | None" = None  # the one that is open
        self._open: int = -1  # its index
        self._sessions: list[tuple[int, int, int]] = []  # (system, component, index of the file), the newest last
        self._bursts: "list[_Burst]" = []

    def is_busy(self) -> bool:
        """True while files are on their way."""
        return bool(self._bursts)

    def serve(self, files: "list[tuple[tuple[Any, ...], int, int]]", for_us: "Callable[[int, int], bool]") -> None:
        """Answer the oldest of `files` (values, system, component) if it is `for_us(system, component)`."""
        if not (files or self._bursts) or not self._link.budget.claim_answer_room():
            return
        if files:
            values, system, component = files.pop(0)
            _, target_system, target_component, payload = values
            if for_us(target_system, target_component):
                self._answer(payload, system, component)
        else:
            burst = self._bursts.pop(0)
            if self._go_on(burst):
                self._bursts.append(burst)  # behind the others

    def _answer(self, payload: bytes, system: int, component: int) -> None:
        sequence, session, opcode, size, _, _, _, offset = struct.unpack_from(_HEADER, payload, 0)
        if opcode in (MAV_FTP_OPCODE_ACK, MAV_FTP_OPCODE_NAK):
            return
        sequence = (sequence + 1) & 0xFFFF
        to = (system, component, sequence, session, opcode)
        index = self._index_of(system, component)
        if opcode in (MAV_FTP_OPCODE_OPENFILERO, MAV_FTP_OPCODE_CALCFILECRC):
            self._find(to, payload[_DATA : _DATA + min(size, _MOST)])
        elif opcode in (MAV_FTP_OPCODE_NONE, MAV_FTP_OPCODE_RESETSESSION, MAV_FTP_OPCODE_TERMINATESESSION):
            self._end_burst(system, component)
            self._acknowledge(to, 0, 0)
        elif opcode not in (MAV_FTP_OPCODE_READFILE, MAV_FTP_OPCODE_BURSTREADFILE):
            self._refuse(to, MAV_FTP_ERR_UNKNOWNCOMMAND)
        elif index < 0 or session:
            self._refuse(to, MAV_FTP_ERR_INVALIDSESSION)
        elif offset >= SIZES[index]:
            self._refuse(to, MAV_FTP_ERR_EOF, offset)
        else:
            piece = min(size or _MOST, _MOST)
            if opcode == MAV_FTP_OPCODE_READFILE:
                self._send_piece(to, index, offset, piece, 0)
            else:
                self._end_burst(system, component)
                piece = min(piece, max(self._link.budget.longest() - _AROUND, _LEAST))
                burst = _Burst(system, component, sequence, index, offset, piece)
                if self._go_on(burst):
                    self._bursts = self._bursts[1 - _BURSTS :]  # the eldest gives way: its station asks again
                    self._bursts.append(burst)

    def _find(self, to: tuple[int, int, int, int, int], name: bytes) -> None:
        """Open a file, or tell its checksum."""
        end = name.find(b"\0")
        name = (name if end < 0 else name[:end]).lstrip(b"/")
        for index in range(len(NAMES)):
            if NAMES[index] == name and self._has(index):
                system, component, sequence, _, opcode = to
                number = CRC32S[index]
                if opcode == MAV_FTP_OPCODE_OPENFILERO:
                    number = SIZES[index]
                    self._open_session(system, component, index)
                struct.pack_into("<I", self._payload, _DATA, number)
                self._acknowledge((system, component, sequence, 0, opcode), 4, 0)
                return
        self._refuse(to, MAV_FTP_ERR_FILENOTFOUND)

    def _go_on(self, burst: "_Burst") -> bool:
        """Send the next piece of a burst; False if it was the last."""
        to = (burst.system, burst.component, burst.sequence, 0, MAV_FTP_OPCODE_BURSTREADFILE)
        offset = burst.offset
        burst.sequence = (burst.sequence + 1) & 0xFFFF
        burst.offset += burst.piece
        last = burst.offset >= SIZES[burst.index]
        return self._send_piece(to, burst.index, offset, burst.piece, 1 if last else 0) and not last

    def _send_piece(
        self, to: tuple[int, int, int, int, int], index: int, offset: int, piece: int, complete: int
    ) -> bool:
        """Send bytes of a file; False if it cannot be read."""
        piece = min(piece, SIZES[index] - offset)
        file = self._file if self._has(index) else None
        try:
            if file is None:
                raise OSError
            file.seek(offset)
            file.readinto(self._view[_DATA : _DATA + piece])
        except OSError:
            self._refuse(to, MAV_FTP_ERR_FILENOTFOUND)
            return False
        self._acknowledge(to, piece, offset, complete)
        return True

    def _has(self, index: int) -> bool:
        """Have the file of this index open; False if there is none."""
        if self._open != index:
            if self._file is not None:
                self._file.close()
            self._open = -1
            self._file = _open_beside(NAMES[index].decode())
            if self._file is not None:
                self._open = index
        return self._open == index

    def _open_session(self, system: int, component: int, index: int) -> None:
        sessions: list[tuple[int, int, int]] = []
        for session in self._sessions:
            station, part, _ = session
            if station != system or part != component:
                sessions.append(session)
        self._sessions = sessions[1 - _STATIONS :]
        self._sessions.append((system, component, index))

    def _index_of(self, system: int, component: int) -> int:
        """The file that a station has opened, or -1."""
        for station, part, index in self._sessions:
            if station == system and part == component:
                return index
        return -1

    def _end_burst(self, system: int, component: int) -> None:
        self._bursts = [burst for burst in self._bursts if burst.system != system or burst.component != component]

    def _acknowledge(self, to: tuple[int, int, int, int, int], size: int, offset: int, complete: int = 0) -> None:
        self._send(to, MAV_FTP_OPCODE_ACK, size, offset, complete)

    def _refuse(self, to: tuple[int, int, int, int, int], error: int, offset: int = 0) -> None:
        self._payload[_DATA] = error
        self._send(to, MAV_FTP_OPCODE_NAK, 1, offset, 0)

    def _send(
        self, to: tuple[int, int, int, int, int], opcode: int, size: int, offset: int, complete: int
    ) -> None:
        system, component, sequence, session, asked = to
        struct.pack_into(_HEADER, self._payload, 0, sequence, session, opcode, size, asked, complete, 0, offset)
        self._view[_DATA + size :] = self._zeros[size:]
        self._link.answer(FILE_TRANSFER_PROTOCOL, (0, system, component, self._payload))


def _open_beside(name: str) -> "BufferedReader | None":
    """The file of this name beside the firmware, open, or None."""
    try:
        folder = __file__[: max(__file__.rfind("/"), __file__.rfind("\\")) + 1]
        return open(folder + name, "rb")  # kept open for the pieces that follow
    except (OSError, NameError):  # firmware that is frozen into the interpreter has no folder
        return None
