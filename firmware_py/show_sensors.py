"""At a board's console, `import firmware_py.show_sensors`: what the encoders read, for setting them up."""

import sys
import time

from .boards.machine_board import make_encoder
from .boards.settings import LINE_ANGLES, check_settings
from .drivers.line_angles import Axis
from .startup import read_board_file, tell


def show(machine):
    """Print both encoders' readings twice a second until Ctrl-C."""
    values, problem = read_board_file()
    settings, problems = check_settings(values, sys.platform) if problem is None else (None, [problem])
    for text in problems:
        tell("board.py: " + text)
    if problems or settings is None or settings.sensors != LINE_ANGLES:
        tell('board.py: these are for SENSORS = "line-angles"')
        return
    encoders = (make_encoder(machine, settings.azimuth), make_encoder(machine, settings.elevation))
    try:
        while True:
            print(line("azimuth", encoders[0], settings.azimuth), line("elevation", encoders[1], settings.elevation))
            time.sleep(0.5)
    except KeyboardInterrupt:
        pass


def line(name, encoder, entry):
    """One encoder's reading as text: the raw number is what "zero" takes when the line is at zero."""
    steps = Axis(encoder, entry["zero"], entry["direction"]).read()
    if steps is None and not encoder.magnet:
        return "%s: no answer" % name
    angle = "" if steps is None else " %+.1f deg" % (steps * 360 / 4096)
    return "%s: raw %d%s %s" % (name, encoder.raw, angle, encoder.magnet_advice())


if sys.platform in ("rp2", "esp32"):
    import machine

    show(machine)
