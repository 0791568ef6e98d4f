"""Emulated Picos for tests; without MicroPython's image for the board, all tests here skip with a line that says so."""

import shutil
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from sim_bridge.boards.image import board_settings, lay_out
from tests.emulated_pico.flight import ON_A_CABLE, START_S
from tests.emulated_pico.pico import EmulatedPico, why_missing


@pytest.fixture(autouse=True)
def _needs_image() -> None:
    if problem := why_missing():
        pytest.skip(f"no emulated Pico: {problem}")


@pytest.fixture(scope="session")
def laid_out(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str | None], Path]:
    """The files of a board laid out in a folder, as `kite-sitl board-image` does; once, for compiling takes time."""

    @cache
    def lay(architecture: str | None) -> Path:
        folder = tmp_path_factory.mktemp("board")
        lay_out(folder, ON_A_CABLE, architecture)
        return folder

    return lay


@pytest.fixture
def board_folder(tmp_path: Path, laid_out) -> Callable[..., Path]:
    """The files of a board in a folder of the test's own; `settings` go into board.py."""

    def lay(architecture: str | None = "armv6m", **settings: Any) -> Path:
        folder = tmp_path / "board"
        shutil.copytree(laid_out(architecture), folder)
        (folder / "board.py").write_text(board_settings(ON_A_CABLE | settings), "utf-8")
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
