"""What outlives a watchdog reset on an emulated Pico: the flight, whole or told as lost."""

import pytest

from firmware_py.boards.retained_layout import FLIGHT, SIZE
from protocol import dialect
from tests.emulated_pico.filesystem import filesystem_of
from tests.emulated_pico.pico import EmulatedPico
from tests.emulated_pico.station import Station

STANDBY, PARK, TRACK = dialect.KITE_MODE_STANDBY, dialect.KITE_MODE_PARK, dialect.KITE_MODE_TRACK
WATCHDOG_SCRATCH_0 = 0x4005800C
STACK_LIMIT = 8192 - 256  # bytes that MicroPython lets Python use
HANG, RECURSE = 20, 21  # pins: grounded, they make the loop hang, the second one after a recursion to the limit
FAULTS = """
import machine

def recurse(depth):
    return recurse(depth + 1) + 1

def hang(pin):
    while True:
        pass

def recurse_and_hang(pin):
    try:
        recurse(0)
    except RuntimeError:  # maximum recursion depth exceeded
        print("deep")
    hang(pin)

for number, fault in ((20, hang), (21, recurse_and_hang)):
    machine.Pin(number, machine.Pin.IN, machine.Pin.PULL_UP).irq(fault, machine.Pin.IRQ_FALLING)
"""
RESTORED = ["reset: watchdog", "parameters restored after the reset", "back after a reset: PARK"]
LOST = ["reset: watchdog", "nothing retained from before the reset"]


@pytest.fixture
def pico(board_folder, switch_on) -> EmulatedPico:
    """A Pico, its loop running, with faults that pins bring about."""
    folder = board_folder()
    (folder / "main.py").write_text(FAULTS + (folder / "main.py").read_text())
    pico = switch_on(filesystem_of(folder))
    for pin in (HANG, RECURSE):
        pico.pin(pin, True)
    pico.run_until_printed("running as system", 10.0)
    return pico


def block_address(pico: EmulatedPico) -> int:
    """Where the board says that its block is."""
    return pico.peek_word(WATCHDOG_SCRATCH_0)


def hang(pico: EmulatedPico, station: Station, pin: int = HANG) -> None:
    """Let the loop hang until the watchdog resets the board."""
    pico.pin(pin, False)
    began = pico.now
    assert station.run(2.0) == "watchdog"
    assert pico.now - began < 1.1
    pico.pin(pin, True)
    pico.console.clear()
    station.forget()


def test_after_a_hang_in_track_it_parks_with_the_gains_of_the_flight(pico):
    station = Station(pico)
    station.fly(TRACK)
    station.set("INNER_P", 2.5)
    hang(pico, station)
    began = pico.now
    assert station.hear("HEARTBEAT").custom_mode == PARK
    assert pico.now - began < 2.0  # it does not wait for Ctrl-C
    station.run(0.5)
    assert station.texts()[:3] == RESTORED
    assert station.value("INNER_P") == 2.5
    hang(pico, station)  # again, and from where the block is now
    assert station.hear("HEARTBEAT").custom_mode == PARK
    assert station.value("INNER_P") == 2.5


def test_a_recursion_to_the_limit_leaves_the_flight_whole(pico):
    station = Station(pico)
    station.fly(PARK)
    station.set("INNER_P", 2.5)
    before = pico.peek(block_address(pico), SIZE)
    pico.pin(RECURSE, False)
    pico.run_until_printed("deep", 0.5)
    assert pico.measured().stack > STACK_LIMIT - 300
    assert pico.peek(block_address(pico), SIZE) == before
    hang(pico, station, RECURSE)
    assert station.hear("HEARTBEAT").custom_mode == PARK
    assert station.value("INNER_P") == 2.5


def test_a_reset_while_it_starts_leaves_the_flight_whole(pico):
    station = Station(pico)
    station.fly(PARK)
    station.set("INNER_P", 2.5)
    hang(pico, station)
    for seconds in (0.05, 0.15, 0.4, 0.9):  # before and after the block is claimed
        pico.run(seconds)
        pico.restart("watchdog")
    assert station.hear("HEARTBEAT", 4.0).custom_mode == PARK
    assert station.value("INNER_P") == 2.5


def test_a_flight_that_is_spoilt_or_not_to_be_found_is_told_as_lost(pico):
    station = Station(pico)
    for spoil in (spoil_flight, lose_address):
        station.fly(PARK)
        spoil(pico)
        hang(pico, station)
        assert station.hear("HEARTBEAT", 4.0).custom_mode == STANDBY
        station.run(0.5)
        assert station.texts()[:2] == LOST


def spoil_flight(pico: EmulatedPico) -> None:
    place = block_address(pico) + FLIGHT + 40
    pico.poke(place, bytes(byte ^ 1 for byte in pico.peek(place, 1)))


def lose_address(pico: EmulatedPico) -> None:
    pico.poke_word(WATCHDOG_SCRATCH_0, 0x2003FFF0)


def test_power_on_holds_nothing(pico):
    assert 0x20000000 + 65536 < block_address(pico) < 0x20040000 - SIZE  # where no early start reaches
    station = Station(pico)
    station.fly(PARK)
    pico.restart("power")
    station.forget()
    assert station.hear("HEARTBEAT", 6.0).custom_mode == STANDBY
    station.run(0.5)
    assert station.texts()[:2] == ["reset: power-on", "no parameters in storage"]
