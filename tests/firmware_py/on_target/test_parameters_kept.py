"""Parameters on flash and in retained memory, under whatever interpreter runs this: plain asserts, no pytest.

Where the interpreter has littlefs, the filesystem of the boards, power is cut at every write to its blocks too.
"""

import os
import struct

from firmware_py.boards.file_storage import FileStorage
from firmware_py.boards.interface import EVENT_MODE
from firmware_py.boards.retained_layout import (
    EVENT_BYTES,
    EVENT_COUNT,
    EVENTS,
    FLIGHT,
    FLIGHT_BYTES,
    SIGNING_TIME,
    SIZE,
    Retained,
    take_over,
)
from firmware_py.parameters.generated_parameters import (
    COUNT,
    DEFAULTS,
    FLAGS,
    GREATESTS,
    LEASTS,
    NAMES,
    READ_ONLY,
    STEPS,
)
from firmware_py.parameters.retained import EventRing, Recovery, SigningTime
from firmware_py.parameters.store import SLOTS, TEMPORARY, ParameterStore
from firmware_py.parameters.values import Parameters

_BLOCK = 512
_BLOCKS = 32
_ERASED = b"\xff" * _BLOCK
_EIO = -5
_MOUNTED = "/kite_flash"


class PowerCutError(Exception):
    """The power is gone."""


class Files:
    """Storage in a dictionary; the power fails in the write that takes `left` [bytes] below zero."""

    def __init__(self, files, left=1 << 30):
        self.files = dict(files)
        self.left = left

    def read(self, name):
        return self.files.get(name)

    def write(self, name, data):
        self.files[name] = data[: max(0, self.left)]
        self.left -= len(data)
        if self.left < 0:
            raise PowerCutError()

    def rename(self, old, new):
        self.files[new] = self.files.pop(old)


class Memory:
    """Retained memory, at first with noise in it."""

    def __init__(self):
        self.data = bytes([index % 256 for index in range(SIZE)])

    def read(self, offset, size):
        return self.data[offset : offset + size]

    def write(self, offset, data):
        self.data = self.data[:offset] + bytes(data) + self.data[offset + len(data) :]


class Flash:
    """A block device; `left` writes and erasures are done in full, and half of the next one.

    Without power it answers EIO and allocates nothing: the interpreter may close a file while it collects garbage.
    """

    def __init__(self, data=None, left=1 << 30):
        self.data = bytearray(data if data is not None else _ERASED * _BLOCKS)
        self.left = left

    def readblocks(self, block, buffer, offset=0):
        if self.left < 0:
            return _EIO
        start = block * _BLOCK + offset
        buffer[:] = self.data[start : start + len(buffer)]
        return 0

    def writeblocks(self, block, buffer, offset=0):
        return self._change(block * _BLOCK + offset, buffer)

    def ioctl(self, request, argument):
        if request == 4:
            return _BLOCKS
        if request == 5:
            return _BLOCK
        if request == 6:
            return self._change(argument * _BLOCK, _ERASED)
        return 0

    def _change(self, start, data):
        if self.left < 0:
            return _EIO
        done = len(data) if self.left else len(data) // 2
        self.data[start : start + done] = data[:done]
        self.left -= 1
        if self.left < 0:
            raise PowerCutError()
        return 0


def _set(number):
    """A set of parameters that differs from those of other numbers in most values."""
    parameters = Parameters()
    for index in range(COUNT):
        least, greatest, step, fixed = LEASTS[index], GREATESTS[index], STEPS[index], FLAGS[index] & READ_ONLY
        value = greatest if number % 2 else least
        if not step:
            value = least + (greatest - least) * (index + number) / (COUNT + 8)
        value = struct.unpack("<f", struct.pack("<f", value))[0]
        if not fixed and not parameters.refusal(index, value, False):
            parameters.set(index, value)
        assert number == 0 or value != DEFAULTS[index] or step or fixed
    return parameters


def _bytes(parameters):
    return struct.pack("<" + "f" * COUNT, *parameters.values)


def _loaded(storage):
    """All values of a firmware that has just started, as bytes."""
    parameters = Parameters()
    ParameterStore(storage).load(parameters)
    return _bytes(parameters)


def _files_after(count):
    storage = Files({})
    for number in range(1, count + 1):
        assert ParameterStore(storage).save(_set(number))
    return storage.files


def test_values_come_back_to_the_bit():
    for count in (1, 2, 3):
        assert _loaded(Files(_files_after(count))) == _bytes(_set(count))
    assert _bytes(_set(1)) != _bytes(_set(2))


def test_a_power_cut_at_every_byte_of_a_write():
    for count in (0, 1, 2):
        files = _files_after(count)
        old = _bytes(_set(count)) if count else _bytes(Parameters())
        size = len(_files_after(1)[SLOTS[0]])
        for left in range(0, size, 7):
            storage = Files(files, left)
            try:
                ParameterStore(storage).save(_set(5))
                raise AssertionError("there was power all along")
            except PowerCutError:
                pass
            assert len(storage.files[TEMPORARY]) == left
            storage.left = 1 << 30
            assert _loaded(storage) == old
            assert ParameterStore(storage).save(_set(6))
            assert _loaded(storage) == _bytes(_set(6))


def test_a_record_of_another_version():
    parameters = Parameters()
    name = NAMES[0]
    body = struct.pack("<4sIH", b"KPR1", 3, 3)
    for stored, value in ((name, 2.5), (b"NOT_HERE_ANYMORE", 1.0), (b"TURN_K", 99.0)):
        body += struct.pack("<16sf", stored, value)
    crc = 0xFFFF
    for byte in body:
        crc ^= byte
        for _ in range(8):
            crc = (crc >> 1) ^ 0x8408 if crc & 1 else crc >> 1
    report = ParameterStore(Files({SLOTS[1]: body + struct.pack("<H", crc)})).load(parameters)
    assert (report.found, report.loaded) == (True, 1)
    assert parameters.values[0] == 2.5
    assert report.unknown == ["NOT_HERE_ANYMORE"]
    assert report.refused == ["TURN_K"]
    assert "TURN_K" not in report.missing and name.decode() not in report.missing and "OUTER_L" in report.missing


def test_retained_memory():
    memory = Memory()
    recovery = Recovery(memory)
    assert recovery.load(Parameters()) is None
    for armed in (True, False):
        recovery.write(_set(3), armed)
        parameters = Parameters()
        assert Recovery(memory).load(parameters) is armed
        assert _bytes(parameters) == _bytes(_set(3))
    whole = memory.data
    for position in range(FLIGHT, FLIGHT + 17 + 4 * COUNT, 5):
        memory.data = whole[:position] + bytes([whole[position] ^ 4]) + whole[position + 1 :]
        assert Recovery(memory).load(Parameters()) is None


def test_a_ring_of_events_outlives_resets_and_loses_only_what_is_spoilt():
    memory = Memory()
    ring = EventRing(memory)
    assert ring.entries() == []
    for value in range(40):
        if value % 7 == 0:
            ring = EventRing(memory)  # a reset
        ring.append(EVENT_MODE, value, 4000000000 + value)
    assert ring.entries() == [(value, EVENT_MODE, 4000000000 + value, float(value)) for value in range(24, 40)]
    torn = EVENTS + 30 % EVENT_COUNT * EVENT_BYTES + 5
    memory.data = memory.data[:torn] + bytes([memory.data[torn] ^ 4]) + memory.data[torn + 1 :]
    assert [entry[0] for entry in EventRing(memory).entries()] == [number for number in range(24, 40) if number != 30]


def test_the_numbers_of_events_go_round():
    memory = Memory()
    memory.write(EVENTS, bytes(EVENT_COUNT * EVENT_BYTES))
    ring = EventRing(memory)
    ring._next = 65530
    for value in range(12):
        ring.append(EVENT_MODE, value, value)
    assert [entry[3] for entry in ring.entries()] == [float(value) for value in range(12)]
    assert EventRing(memory)._next == 6


def test_a_signing_time():
    memory = Memory()
    assert SigningTime(memory).read() is None
    for timestamp in (0, 1, 0x123456789ABC, 0xFFFFFFFFFFFF):
        SigningTime(memory).write(timestamp)
        assert SigningTime(memory).read() == timestamp
    memory.data = memory.data[:SIGNING_TIME] + b"\x00" + memory.data[SIGNING_TIME + 1 :]
    assert SigningTime(memory).read() is None


def test_each_part_has_a_place_of_its_own():
    memory = Memory()
    SigningTime(memory).write(1234567)
    recovery = Recovery(memory)
    recovery.write(_set(3), True)
    ring = EventRing(memory)
    for value in range(EVENT_COUNT):
        ring.append(EVENT_MODE, value, value)
    assert recovery.load(Parameters()) is True
    assert len(ring.entries()) == EVENT_COUNT
    assert SigningTime(memory).read() == 1234567
    assert 19 + 4 * COUNT <= FLIGHT_BYTES and FLIGHT + FLIGHT_BYTES == SIZE


def test_a_block_of_another_layout_is_not_taken_over():
    block = bytearray(SIZE)
    take_over(block, None)
    SigningTime(Retained(block)).write(1)
    for old, taken in ((bytes(block), 1), (bytes(SIZE), None), (bytes(block)[:-1], None), (b"", None),
                       (b"?" + bytes(block)[1:], None)):
        after = bytearray(SIZE)
        take_over(after, old)
        assert SigningTime(Retained(after)).read() == taken
        assert after[:8] == block[:8]


def _mount(flash):
    os.mount(os.VfsLfs2(flash), _MOUNTED)  # type: ignore[attr-defined]
    return FileStorage(_MOUNTED)


def _unmount():
    os.umount(_MOUNTED)  # type: ignore[attr-defined]


def _save_until_the_cut(flash, parameters):
    """Save on `flash`; True if the power lasted."""
    try:
        storage = _mount(flash)
        try:
            return ParameterStore(storage).save(parameters) and flash.left >= 0
        finally:
            _unmount()
    except PowerCutError:
        return False


def _on_flash(data):
    """What a firmware finds that starts with this on its flash."""
    storage = _mount(Flash(data))
    try:
        return _loaded(storage)
    finally:
        _unmount()


def test_littlefs_with_power_cuts_at_every_write_to_its_blocks():
    if not hasattr(os, "VfsLfs2"):
        return  # CPython
    flash = Flash()
    os.VfsLfs2.mkfs(flash)  # type: ignore[attr-defined]
    old = _bytes(Parameters())
    for number in range(1, 6):
        before = bytes(flash.data)
        new = _bytes(_set(number))
        seen = []
        left = 0
        while True:
            cut = Flash(before, left)
            lasted = _save_until_the_cut(cut, _set(number))
            found = _on_flash(cut.data)
            assert found in (old, new), (number, left)
            seen.append(found == new)
            if lasted:
                break
            left += 1
        assert left > 4 and not seen[0] and seen[-1]
        flash = Flash(cut.data)
        old = new
