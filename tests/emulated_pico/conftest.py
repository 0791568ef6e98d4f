"""Emulated Picos for tests; without MicroPython's image for the board, all tests here skip with a line that says so."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from sim_bridge.boards.image import lay_out
from tests.emulated_pico.flight import BAUD
from tests.emulated_pico.pico import EmulatedPico, why_missing

ON_A_CABLE = {"LINK": "uart", "UART": 0, "UART_TX": 0, "UART_RX": 1, "UART_BAUD": BAUD, "SENSORS": "hil"}
START_S = 20.0  # more than any start takes


@pytest.fixture(autouse=True)
def _needs_image() -> None:
    if problem := why_missing():
        pytest.skip(f"no emulated Pico: {problem}")


@pytest.fixture
def board_folder(tmp_path: Path) -> Callable[..., Path]:
    """The files of a board laid out in a folder, as `kite-sitl board-image` does; `settings` go into board.py."""

    def lay(architecture: str | None = "armv6m", **settings: Any) -> Path:
        folder = tmp_path / "board"
        lay_out(folder, ON_A_CABLE | settings, architecture)
        return folder

    return lay


@pytest.fixture
def switch_on() -> Iterator[Callable[..., EmulatedPico]]:
    """Switches on an EmulatedPico (same arguments), and all off after the test."""
    picos: list[EmulatedPico] = []

    def switch(filesystem: bytes | None = None) -> EmulatedPico:
        picos.append(EmulatedPico(filesystem))
        return picos[-1]

    yield switch
    for pico in picos:
        pico.close()


@pytest.fixture
def flying_pico(board_folder, switch_on) -> EmulatedPico:
    """A Pico as `make flash` leaves it, switched on, its loop running."""
    from tests.emulated_pico.filesystem import filesystem_of  # noqa: PLC0415  needs what is checked above

    pico = switch_on(filesystem_of(board_folder()))
    pico.run_until_printed("running as system", START_S)
    return pico
