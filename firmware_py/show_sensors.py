"""At a board's console, `import firmware_py.show_sensors`: what the encoders read, for setting them up."""

import sys
import time

from .boards.machine_board import make_encoder
from .boards.settings import check_settings
from .drivers.line_angles import Axis
from .startup import read_board_file, tell

TYPE_CHECKING = False
if TYPE_CHECKING:
    from types import ModuleType

    from .boards.settings import Entry
    from .drivers.as5600 import As5600


def show(machine: "ModuleType") -> None:
    """Print both encoders' readings twice a second until Ctrl-C."""
    values, problem = read_board_file()
    settings, problems = check_settings(values, sys.platform) if problem is None else (None, [problem])
    for text in problems:
        tell("board.py: " + text)
    azimuth = None if settings is None else settings.azimuth
    elevation = None if settings is None else settings.elevation
    if problems or azimuth is None or elevation is None:
        tell('board.py: these are for SENSORS = "line-angles"')
        return
    encoders = (make_encoder(machine, azimuth), make_encoder(machine, elevation))
    try:
        while True:
            print(line("azimuth", encoders[0], azimuth), line("elevation", encoders[1], elevation))
            time.sleep(0.5)
    except KeyboardInterrupt:
        pass


def line(name: str, encoder: "As5600", entry: "Entry") -> str:
    """One encoder's reading as text: the raw number is what "zero" takes when the line is at zero."""
    steps = Axis(encoder, entry["zero"], entry["direction"]).read()
    if steps is None and not encoder.magnet:
        return "%s: no answer" % name
    angle = "" if steps is None else " %+.1f deg" % (steps * 360 / 4096)
    return "%s: raw %d%s %s" % (name, encoder.raw, angle, encoder.magnet_advice())


if sys.platform in ("rp2", "esp32"):
    import machine

    show(machine)
