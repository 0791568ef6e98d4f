"""Parameters on flash: cut the power anywhere, spoil any byte, come from another version."""

import contextlib
import itertools
import random
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from simulated_storage import PowerCutError, SimulatedStorage, flipped

from firmware_py.boards.file_storage import FileStorage
from firmware_py.parameters.persistence import describe
from firmware_py.parameters.store import SLOTS, TEMPORARY, LoadReport, ParameterStore
from firmware_py.parameters.values import Parameters
from protocol.parameter_table import load_parameters
from protocol.single_precision import float32

TABLE = load_parameters()
NAMES = list(TABLE)
SETTABLE = [name for name in NAMES if not TABLE[name].read_only]
DEFAULTS = [parameter.default for parameter in TABLE.values()]
SLOT_A, SLOT_B = SLOTS


def some_set(seed: int) -> list[float]:
    """Values for all parameters, each within its limits, no two sets alike in any that has room for it."""
    draw = random.Random(seed)
    values = []
    for parameter in TABLE.values():
        if parameter.read_only:
            values.append(parameter.default)
            continue
        value = draw.uniform(parameter.least, parameter.greatest)
        if parameter.step:
            value = parameter.least + parameter.step * round((value - parameter.least) / parameter.step)
        values.append(float32(value))
        assert not parameter.problem_with(values[-1])
    return values


def with_values(values: list[float]) -> Parameters:
    parameters = Parameters()
    for index, value in enumerate(values):
        parameters.set(index, value)
    return parameters


def save(storage: SimulatedStorage, values: list[float]) -> bool:
    return ParameterStore(storage).save(with_values(values))


def load(storage: SimulatedStorage) -> tuple[list[float], LoadReport]:
    """The values of a firmware that has just started."""
    parameters = Parameters()
    report = ParameterStore(storage).load(parameters)
    return parameters.values, report


def files_after(*sets: list[float]) -> dict[str, bytes]:
    """What lies on flash after `sets` were saved one after the other."""
    storage = SimulatedStorage()
    for values in sets:
        assert save(storage, values)
    return storage.files


FIRST, SECOND, THIRD, NEW = (some_set(seed) for seed in range(4))
WHOLE = files_after(FIRST, SECOND)
TORN = WHOLE[SLOT_A][:100]

# Both slots in every state, by name: (the set that counts, the files).
STATES = {
    "nothing yet": (DEFAULTS, {}),
    "one set": (FIRST, files_after(FIRST)),
    "two sets": (SECOND, WHOLE),
    "three sets": (THIRD, files_after(FIRST, SECOND, THIRD)),
    "second slot only": (SECOND, {SLOT_B: WHOLE[SLOT_B]}),
    "newer one spoilt": (FIRST, {SLOT_A: WHOLE[SLOT_A], SLOT_B: TORN}),
    "older one spoilt": (SECOND, {SLOT_A: flipped(WHOLE[SLOT_A], 50), SLOT_B: WHOLE[SLOT_B]}),
    "both spoilt": (DEFAULTS, {SLOT_A: b"", SLOT_B: TORN}),
    "a torn file left": (SECOND, WHOLE | {TEMPORARY: TORN}),
    "a whole file left": (SECOND, WHOLE | {TEMPORARY: files_after(THIRD)[SLOT_A]}),
}
EACH_STATE = pytest.mark.parametrize("state", STATES)


def places_to_cut(files: dict[str, bytes]) -> list[tuple[int, int | None]]:
    """(operations, torn bytes) for a cut after every operation of a save, and at every byte of every write."""
    storage = SimulatedStorage(files)
    assert save(storage, NEW)
    places: list[tuple[int, int | None]] = [(0, None)]
    for number, (operation, _) in enumerate(storage.log, start=1):
        if operation == "write":
            places += [(number, count) for count in range(len(WHOLE[SLOT_A]))]
        places.append((number, None))
    return places


@EACH_STATE
def test_the_set_that_counts(state):
    values, files = STATES[state]
    assert load(SimulatedStorage(files))[0] == values


@EACH_STATE
def test_a_power_cut_anywhere_leaves_the_whole_old_or_the_whole_new_set(state):
    old, files = STATES[state]
    seen = {"old": 0, "new": 0}
    for operations, torn_bytes in places_to_cut(files):
        storage = SimulatedStorage(files)
        storage.cut_after(operations, torn_bytes)
        with pytest.raises(PowerCutError):
            save(storage, NEW)
        storage.power_up()
        values = load(storage)[0]
        assert values in (old, NEW), (operations, torn_bytes)
        seen["new" if values == NEW else "old"] += 1
    assert seen["old"] > len(WHOLE[SLOT_A])
    assert seen["new"] == 1  # the rename is the moment from which it counts


@EACH_STATE
def test_the_save_after_a_power_cut_goes_well(state):
    _, files = STATES[state]
    for operations, torn_bytes in places_to_cut(files)[::13]:
        storage = SimulatedStorage(files)
        storage.cut_after(operations, torn_bytes)
        with pytest.raises(PowerCutError):
            save(storage, NEW)
        storage.power_up()
        for values in (THIRD, NEW, FIRST):
            assert save(storage, values)
            assert load(storage)[0] == values


def test_power_cuts_again_and_again():
    """A board with a loose contact: whatever was whole last stays until something newer is."""
    draw = random.Random(7)
    storage = SimulatedStorage()
    stored = DEFAULTS
    sets = itertools.cycle(some_set(seed) for seed in range(10, 20))
    for wanted in itertools.islice(sets, 300):
        storage.cut_after(draw.randint(0, 6), draw.choice([None, draw.randint(0, 600)]))
        with contextlib.suppress(PowerCutError):
            save(storage, wanted)
        storage.power_up()
        values = load(storage)[0]
        assert values in (stored, wanted)
        stored = values
    assert stored != DEFAULTS


def test_values_come_back_to_the_bit():
    values = some_set(5)
    values[NAMES.index("TURN_OFFSET")] = -0.0
    values[NAMES.index("EIGHT_AZIMUTH")] = float32(1e-42)  # below the least normal number
    storage = SimulatedStorage(files_after(values))
    assert struct.pack(f"<{len(NAMES)}f", *load(storage)[0]) == struct.pack(f"<{len(NAMES)}f", *values)


def test_saves_take_turns_and_the_same_set_is_not_written_twice():
    storage = SimulatedStorage()
    for values, slot in ((FIRST, SLOT_A), (SECOND, SLOT_B), (THIRD, SLOT_A), (FIRST, SLOT_B)):
        before = dict(storage.files)
        assert save(storage, values)
        assert {name for name in storage.files if storage.files[name] != before.get(name)} == {slot}
        storage.log.clear()
        assert save(storage, values)
        assert storage.changes == []


@pytest.mark.parametrize("mask", [0x01, 0x80, 0xFF])
def test_any_byte_spoilt_leaves_the_other_slot(mask):
    for spoilt, kept in ((SLOT_A, SECOND), (SLOT_B, FIRST)):
        for position in range(len(WHOLE[spoilt])):
            values, report = load(SimulatedStorage(WHOLE | {spoilt: flipped(WHOLE[spoilt], position, mask)}))
            assert values == kept, (spoilt, position)
            assert report.damaged == 1


@pytest.mark.parametrize("spoilt", SLOTS)
def test_any_length_spoilt_leaves_the_other_slot(spoilt):
    kept = FIRST if spoilt == SLOT_B else SECOND
    whole = WHOLE[spoilt]
    for wrong in [whole[:length] for length in range(len(whole))] + [whole + b"\0", whole + whole, b"\xff" * 4096]:
        values, report = load(SimulatedStorage(WHOLE | {spoilt: wrong}))
        assert values == kept
        assert (report.found, report.damaged) == (True, 1)


WHERE = st.tuples(st.integers(0, len(WHOLE[SLOT_A]) - 1), st.integers(0, 255))


@given(first=WHERE, second=WHERE)
def test_a_byte_spoilt_in_each_slot(first, second):
    spoilt = {SLOT_A: flipped(WHOLE[SLOT_A], *first), SLOT_B: flipped(WHOLE[SLOT_B], *second)}
    values, report = load(SimulatedStorage(spoilt))
    assert values == (SECOND if not second[1] else FIRST if not first[1] else DEFAULTS)
    assert report.found == (values != DEFAULTS)


@given(files=st.fixed_dictionaries({}, optional={name: st.binary(max_size=1000) for name in (*SLOTS, TEMPORARY)}))
def test_anything_at_all_on_flash_does_no_harm(files):
    storage = SimulatedStorage(files)
    assert load(storage)[0] == DEFAULTS
    assert save(storage, NEW)
    assert load(storage)[0] == NEW


def record(entries: list[tuple[str | bytes, float]], generation: int = 7) -> bytes:
    """A record as another version would write it, made without the firmware's code: the format is a promise."""
    body = struct.pack("<4sIH", b"KPR1", generation, len(entries))
    for name, value in entries:
        body += struct.pack("<16sf", name.encode() if isinstance(name, str) else name, value)
    crc = 0xFFFF
    for byte in body:
        crc ^= byte
        for _ in range(8):
            crc = (crc >> 1) ^ 0x8408 if crc & 1 else crc >> 1
    return body + struct.pack("<H", crc)


def test_the_format_is_as_promised():
    assert WHOLE[SLOT_A] == record([(n, v) for n, v in zip(NAMES, FIRST, strict=True) if n in SETTABLE], 1)


def load_record(entries: list[tuple[str | bytes, float]]) -> tuple[dict[str, float], LoadReport, list[str]]:
    """(values by name, report, texts) after a start with this record on flash."""
    values, report = load(SimulatedStorage({SLOT_A: record(entries)}))
    texts = [text for _, text in describe(report)]
    assert all(len(text) <= 50 for text in texts)
    return dict(zip(NAMES, values, strict=True)), report, texts


def test_a_version_with_fewer_names():
    values, report, texts = load_record([("OUTER_L", 3.0), ("INNER_P", 2.5)])
    assert values == TABLE_DEFAULTS | {"OUTER_L": 3.0, "INNER_P": 2.5}
    assert report.missing == [name for name in SETTABLE if name not in ("OUTER_L", "INNER_P")]
    assert texts == ["2 parameters from storage", f"not stored, at default: FF_GAIN +{len(SETTABLE) - 3}"]


def test_a_version_with_more_names():
    entries: list[tuple[str | bytes, float]] = [(name, TABLE[name].default) for name in SETTABLE]
    entries[3:3] = [("OLD_GAIN", 99.0), ("SIXTEEN_LETTERS_", 1.0), (b"\xff\x00\x80", 1.0)]
    entries.append(("INNER_P", 2.5))  # named twice: the last one counts
    values, report, texts = load_record(entries)
    assert values == TABLE_DEFAULTS | {"INNER_P": 2.5}
    assert report.unknown == ["OLD_GAIN", "SIXTEEN_LETTERS_", ""]
    assert (report.missing, report.refused) == ([], [])
    assert "skipped, unknown here: OLD_GAIN +2" in texts


def test_names_of_another_version_are_told_as_far_as_they_can_be_printed():
    _, report, _ = load_record([(b"\x1f A~\x7f\x80z", 1.0)])
    assert report.unknown == [" A~z"]


TABLE_DEFAULTS = dict(zip(NAMES, DEFAULTS, strict=True))
OUT_OF_RANGE = [
    ("INNER_P", 51.0), ("INNER_P", -0.001), ("TURN_K", 0.0), ("INNER_P", float("nan")), ("INNER_P", float("inf")),
    ("LOOP_HZ", 50.5), ("EIGHT_DIRECTION", 0.0), ("TABLE_VERSION", 9.0),
]


@pytest.mark.parametrize(("name", "value"), OUT_OF_RANGE)
def test_a_value_that_is_out_of_range_now(name, value):
    values, report, texts = load_record([(name, value), ("OUTER_L", 3.0)])
    assert values == TABLE_DEFAULTS | {"OUTER_L": 3.0}
    assert report.refused == [name]
    assert name not in report.missing
    assert f"skipped, out of range: {name}" in texts


def test_a_record_without_entries():
    values, report, _ = load_record([])
    assert values == TABLE_DEFAULTS
    assert (report.found, report.missing) == (True, SETTABLE)


def test_texts_for_nothing_and_for_damage():
    assert [text for _, text in describe(load(SimulatedStorage())[1])] == ["no parameters in storage"]
    report = load(SimulatedStorage({SLOT_A: b"", SLOT_B: b"x"}))[1]
    assert [t for _, t in describe(report)] == ["no parameters in storage", "2 of 2 parameter slots damaged"]


def test_the_longest_names_fit_a_text():
    report = LoadReport()
    report.unknown = report.refused = report.missing = ["SIXTEEN_LETTERS_"] * 1000
    assert all(len(text) <= 50 for _, text in describe(report))


@pytest.mark.parametrize("fault", ["full", "worn"])
def test_storage_that_fails_says_so_and_the_old_set_stays(fault):
    storage = SimulatedStorage(WHOLE)
    setattr(storage, fault, True)
    assert not save(storage, NEW)
    assert load(storage)[0] == SECOND
    setattr(storage, fault, False)
    assert save(storage, NEW)
    assert load(storage)[0] == NEW


class UnreadableSlot(SimulatedStorage):
    """A slot on a bad block."""

    def read(self, name: str) -> bytes | None:
        if name == SLOT_B:
            raise OSError(5)
        return super().read(name)


def test_a_slot_that_cannot_be_read_counts_as_damaged():
    storage = UnreadableSlot(WHOLE)
    values, report = load(storage)
    assert (values, report.damaged) == (FIRST, 1)


@pytest.mark.parametrize("spoilt", SLOTS)
def test_whether_the_newest_set_is_stored_is_known_beside_a_damaged_slot(spoilt):
    storage = SimulatedStorage(WHOLE | {spoilt: TORN})
    left = FIRST if spoilt == SLOT_B else SECOND
    assert ParameterStore(storage).holds(with_values(left))
    assert not ParameterStore(storage).holds(with_values(NEW))


def test_storage_in_a_folder(tmp_path):
    folder = tmp_path / "kite"
    for values in (FIRST, SECOND, THIRD):
        assert ParameterStore(FileStorage(str(folder))).save(with_values(values))
        parameters = Parameters()
        assert ParameterStore(FileStorage(str(folder))).load(parameters).found
        assert parameters.values == values
    assert sorted(path.name for path in folder.iterdir()) == sorted(SLOTS)
    FileStorage(str(folder)).remove(SLOT_A)
    assert FileStorage(str(folder)).read(SLOT_A) is None


def test_a_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    storage = FileStorage(str(tmp_path / "file"))
    assert not ParameterStore(storage).save(Parameters())
    report = ParameterStore(storage).load(Parameters())
    assert not report.found
