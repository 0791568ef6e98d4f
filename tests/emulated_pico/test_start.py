"""An emulated Pico from power-on to its first heartbeat, and its parameters over a power cycle."""

from protocol import dialect
from tests.emulated_pico.filesystem import filesystem_of
from tests.emulated_pico.station import Station


def test_it_beats_its_heart(flying_pico):
    assert flying_pico.now < 4.5  # of which two seconds are for Ctrl-C
    beat = Station(flying_pico).hear("HEARTBEAT")
    assert (beat.type, beat.custom_mode) == (dialect.MAV_TYPE_KITE, dialect.KITE_MODE_STANDBY)


def test_laid_out_as_sources_it_starts_too(board_folder, switch_on):
    pico = switch_on(filesystem_of(board_folder(None)))
    pico.run_until_printed("running as system", 12.0)
    assert Station(pico).hear("HEARTBEAT").type == dialect.MAV_TYPE_KITE


def test_parameters_outlive_a_loss_of_power_and_a_save_spoils_no_statistics(flying_pico):
    station = Station(flying_pico)
    station.kite = True
    station.set("INNER_P", 2.5)
    before = flying_pico.measured().flash_operations
    station.run(1.5)
    assert flying_pico.measured().flash_operations > before
    assert "parameters saved" in station.texts()
    station.forget()
    station.run(0.5)
    state = station.of_kind("KITE_STATE")[-1]
    assert 0 < state.tick_worst_us < 65535 and state.overruns == 0
    flying_pico.restart("power")
    station.forget()
    station.hear("HEARTBEAT", 6.0)
    assert station.value("INNER_P") == 2.5
