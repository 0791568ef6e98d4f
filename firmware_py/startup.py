"""From power-on to the loop: settings, board, a way to stop, flight. Errors are reported and lead to the console."""

import gc
import sys
import time

from .autopilot import Autopilot
from .boards.interface import WATCHDOG
from .boards.light import SETTINGS, STOPPED
from .boards.settings import check_settings
from .garbage import run_in_order
from .loop import run_real_time
from .mavlink.link import MavlinkLink
from .parameters.generated_parameters import SYSTEM_ID

TYPE_CHECKING = False
if TYPE_CHECKING:
    from types import ModuleType
    from typing import Any, Final

    from .boards.machine_board import MachineBoard
    from .boards.settings import Settings

_WAY_OUT_MS = 2000  # type: Final
_LOOK_MS = 50  # type: Final


def tell(text: str) -> None:
    """Print to the console."""
    print("kitepilot: " + text)


def start(platform: str) -> None:
    """Start the board of this sys.platform; returns only if it is not to fly."""
    module = _board_module(platform)
    values, problem = read_board_file()
    settings, problems = check_settings(values, platform) if problem is None else (None, [problem])
    for text in problems:
        tell("board.py: " + text)
    if module is None:
        tell("no board module for platform %s: there are rp2 and esp32" % platform)
    elif problems or settings is None:
        module.blink(settings.light_pin if settings else module.LIGHT, SETTINGS)
    else:
        board = _make_board(module, settings)
        if board is not None:
            _run(board, settings)


def read_board_file() -> "tuple[dict[str, Any], str | None]":
    """Return (entries of /board.py by name, None), or ({}, what is wrong with the file)."""
    try:
        import board  # noqa: PLC0415  # pyright: ignore[reportMissingImports]  the user's, on the board
    except ImportError as error:
        if "'board'" in str(error):
            return {}, "not found: copy the template and enter your settings"
        return {}, str(error)
    except SyntaxError as error:
        return {}, "not Python: " + str(error)
    except Exception as error:  # whatever the user wrote
        return {}, "%s: %s" % (type(error).__name__, error)
    return {name: getattr(board, name) for name in dir(board)}, None


def _board_module(platform: str) -> "ModuleType | None":
    if platform == "rp2":
        from .boards import rp2_board as module  # noqa: PLC0415
    elif platform == "esp32":
        from .boards import esp32_board as module  # noqa: PLC0415
    else:
        module = None
    return module


def _make_board(module: "ModuleType", settings: "Settings") -> "MachineBoard | None":
    """The board, or None: then the hardware refused what the settings say."""
    try:
        return module.Board(settings, tell)
    except (ValueError, OSError, TypeError) as error:
        tell("board.py: rejected by the hardware: %s" % error)
        module.blink(settings.light_pin, SETTINGS)
        return None


def _run(board: "MachineBoard", settings: "Settings") -> None:
    """Fly until Ctrl-C, or a grounded maintenance pin before it begins."""
    try:
        reason = _way_out(board)
        if reason is None:
            _fly(board, settings)
    except KeyboardInterrupt:
        reason = "Ctrl-C"
    except Exception as error:
        _print_exception(error)
        if board.is_watched():
            if board.actuator is not None:
                board.actuator.write(0.0, False)
            tell("the loop failed; the watchdog resets the board")
            return
        reason = "a failure"
    board.stop(STOPPED)
    tell("stopped by %s; machine.reset() starts again" % reason)


def _way_out(board: "MachineBoard") -> str | None:
    """Give two seconds in which Ctrl-C stops; return why not to fly, or None.

    After a reset by the watchdog the kite may be in the air, and there is no such time.
    """
    if board.wants_maintenance():
        return "the maintenance pin"
    if board.reset_cause == WATCHDOG:
        return None
    tell("flying in 2 s; Ctrl-C stops")
    for _ in range(_WAY_OUT_MS // _LOOK_MS):
        time.sleep(_LOOK_MS / 1000)
        if board.wants_maintenance():
            return "the maintenance pin"
    return None


def _fly(board: "MachineBoard", settings: "Settings") -> None:
    link = MavlinkLink(board.transport)
    autopilot = Autopilot(link, False, board.storage, board.retained, board.reset_cause)
    if autopilot.parameters.values[SYSTEM_ID] != settings.system_id:
        autopilot.parameters.set(SYSTEM_ID, float(settings.system_id))
    board.light.ask_storage(autopilot.keeper.storage_fails)
    link.set_system(settings.system_id)  # before the first tick: what is for it may wait already
    tell("running as system %d, link %s, sensors %s" % (settings.system_id, settings.link, settings.sensors))
    if hasattr(gc, "threshold"):
        getattr(gc, "threshold")(-1)  # noqa: B009  everything is loaded: from here on the loop says when
    board.start_watchdog()
    run_in_order(
        lambda: run_real_time(autopilot, board),
        (autopilot.parameters, link, autopilot.kite, autopilot.prediction, autopilot.guidance, autopilot.modes),
    )


def _print_exception(error: "BaseException") -> None:
    if hasattr(sys, "print_exception"):
        getattr(sys, "print_exception")(error)  # noqa: B009  MicroPython's
    else:
        print(repr(error))
