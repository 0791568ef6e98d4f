"""`kite-sitl flash` over a pseudo-terminal, with mpremote as it is, onto an emulated Pico with nothing on it."""

import os
import select
import subprocess
import sys
import tty

from tests.emulated_pico.pico import EmulatedPico
from tests.emulated_pico.station import Station

_QUANTUM_S = 0.004


def run_beside(pico: EmulatedPico, *command: str) -> str:
    """Run `command`, PORT in it being the board's console, while the board's time passes; what it printed."""
    board, computer = os.openpty()
    tty.setraw(computer)
    words = [os.ttyname(computer) if word == "PORT" else word for word in command]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        while process.poll() is None:
            relay(pico, board)
        assert process.stdout
        printed = process.stdout.read()
    os.close(board)
    os.close(computer)
    assert process.returncode == 0, printed
    return printed


def relay(pico: EmulatedPico, terminal: int) -> None:
    """Let a moment of the board's time pass, and carry over what either side has sent."""
    while select.select([terminal], [], [], 0)[0]:
        pico.type(os.read(terminal, 4096))
    pico.console.clear()
    pico.run(_QUANTUM_S)
    if pico.console:
        os.write(terminal, bytes(pico.console))


def test_an_empty_board_is_flashed_and_beats_its_heart(switch_on):
    pico = switch_on(None)
    pico.run(1.0)
    printed = run_beside(pico, sys.executable, "-m", "sim_bridge.cli.main", "flash", "PORT", "--set", "SYSTEM_ID=7",
                         "--set", "UART_BAUD=460800")
    assert printed.startswith("nothing of kitepilot on this board: it is new, or has lost its file system")
    assert "0 up to date, 0 to remove" in printed and "restarted; its link is a UART" in printed
    assert pico.cause_of_reset == "reset"
    pico.run_until_printed("running as system 7, link uart", 10.0)
    assert Station(pico).hear("HEARTBEAT").get_srcSystem() == 7
