"""An emulated Pico's flash: full, spoilt, torn by a loss of power, or with no file system at all."""

from itertools import pairwise

import pytest

from firmware_py.parameters.store import SLOTS
from tests.emulated_pico.filesystem import BLOCK_BYTES, BLOCKS, OFFSET, files_of, filesystem_of
from tests.emulated_pico.pico import EmulatedPico
from tests.emulated_pico.station import Station

LIGHT = 25
START_S = 10.0


def flashes(pico: EmulatedPico, seconds: float) -> int:
    """How often the light comes on in that time."""
    seen = []
    for _ in range(round(seconds / 0.02)):
        pico.run(0.02)
        seen.append(pico.pin(LIGHT))
    return sum(later and not earlier for earlier, later in pairwise(seen))


def saved(station: Station, value: float) -> bool:
    """Set a parameter and wait until the board says that it is saved, or that it is not."""
    station.set("INNER_P", value)
    station.run(1.6)
    told = [text for text in station.texts() if text.startswith("parameters ")][-1]
    return {"parameters saved": True, "parameters not saved: storage failed": False}[told]


def test_a_full_storage_is_told_and_what_was_saved_stays(board_folder, switch_on):
    folder = board_folder()
    pico = switch_on(filesystem_of(folder))
    pico.run_until_printed("running as system", START_S)
    station = Station(pico)
    assert saved(station, 2.5)
    pico.restart("power")
    (folder / "kitepilot").mkdir()
    for name, data in files_of(pico.read_flash(OFFSET, BLOCKS * BLOCK_BYTES)).items():
        (folder / name.strip("/")).write_bytes(data)
    pico.write_flash(OFFSET, filesystem_of(folder, full=True))
    pico.console.clear()
    pico.run_until_printed("running as system", START_S)
    assert station.value("INNER_P") == 2.5
    assert not saved(station, 3.5)
    assert flashes(pico, 2.1) in (4, 5)
    pico.restart("power")
    station.forget()
    station.hear("HEARTBEAT", START_S)
    assert station.value("INNER_P") == 2.5


def test_slots_that_are_both_spoilt_are_told(board_folder, switch_on):
    folder = board_folder()
    (folder / "kitepilot").mkdir()
    for slot in SLOTS:
        (folder / "kitepilot" / slot).write_bytes(b"noise" * 100)
    pico = switch_on(filesystem_of(folder))
    pico.run_until_printed("running as system", START_S)
    station = Station(pico)
    assert station.value("INNER_P") == 1.5
    station.run(1.0)
    assert "2 of 2 parameter slots damaged" in station.texts()
    assert flashes(pico, 2.1) in (4, 5)
    assert saved(station, 2.5)


def test_firmware_that_is_damaged_is_told_by_light_and_console(board_folder, switch_on):
    folder = board_folder()
    loop = folder / "firmware_py" / "loop.mpy"
    loop.write_bytes(b"\x55" * len(loop.read_bytes()))
    pico = switch_on(filesystem_of(folder))
    pico.run_until_printed("the firmware on this board is damaged: flash it again", START_S)
    assert flashes(pico, 2.0) in (7, 8, 9)
    pico.type("\r\n1 + 1\r\n")
    pico.run_until_printed("\n2\r\n", 1.0)  # the console is free


def test_a_file_system_that_is_lost_leaves_an_empty_one_and_mpremote_s_console(board_folder, switch_on):
    """MicroPython formats it before any program of ours could tell: docs/boards.md says what a dark light means."""
    pico = switch_on(filesystem_of(board_folder()))
    pico.write_flash(OFFSET, b"\xff" * 2 * BLOCK_BYTES)  # both superblocks
    assert flashes(pico, 3.0) == 0
    pico.type("\r\n")
    pico.run_until_printed(">>> ", START_S)
    assert files_of(pico.read_flash(OFFSET, BLOCKS * BLOCK_BYTES)) == {}


@pytest.mark.soak
def test_a_loss_of_power_in_any_operation_of_a_save_leaves_the_old_or_the_new_set(board_folder, switch_on):
    image = filesystem_of(board_folder())
    found = []
    while not found or found[-1] is not None:
        found.append(after_a_cut(switch_on(image), len(found) + 1))
    assert len(found) > 4 and found[0] == 2.5 and found[-2] == 3.5
    assert sorted(found[:-1]) == found[:-1]  # up to some operation it is the old one, and then the new


def after_a_cut(pico: EmulatedPico, operation: int) -> float | None:
    """Save 2.5, then 3.5 with a cut in that `operation`; what a start finds, or None if there are not so many."""
    pico.run_until_printed("running as system", START_S)
    station = Station(pico)
    assert saved(station, 2.5)
    station.set("INNER_P", 3.5)
    pico.cut_power(operation)
    if station.run(1.6) == "time":
        return None
    station.forget()
    pico.console.clear()
    pico.run_until_printed("running as system", START_S)
    station.hear("HEARTBEAT")
    assert not any("damaged" in text for text in station.texts())
    return station.value("INNER_P")
