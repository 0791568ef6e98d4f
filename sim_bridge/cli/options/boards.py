"""Options of `kite-sitl board-image` and `flash`."""

from argparse import ArgumentParser

from sim_bridge.boards.architectures import ARCHITECTURES
from sim_bridge.cli.options.listings import add_json_option


def add_image_options(verb: ArgumentParser) -> None:
    """Options of `board-image`."""
    verb.description = (
        "Write main.py, board.py and the compiled firmware into DIR, as they will be on the board. An "
        "existing board.py is kept.")
    verb.add_argument("folder", metavar="DIR", help="the folder; created if needed")
    verb.add_argument("--platform", choices=tuple(ARCHITECTURES), default="rp2", help="default: rp2")
    verb.add_argument("--arch", metavar="ARCH", help="architecture for mpy-cross (default: the platform's)")
    verb.add_argument("--source", action="store_true", help="the firmware as .py instead of .mpy")
    add_json_option(verb)
    _add_settings(verb)


def add_flash_options(verb: ArgumentParser) -> None:
    """Options of `flash`."""
    verb.description = (
        "Copy the changed files to the board at PORT with mpremote, write board.py if there is none, "
        "restart the board and wait for its first HEARTBEAT.")
    verb.add_argument("port", metavar="PORT", help="serial port of the board's console; `mpremote connect list`")
    verb.add_argument("--dry-run", action="store_true", help="show what would be done to an empty Pico; change "
                                                             "nothing")
    verb.add_argument("--listen", metavar="DEVICE[:BAUD]", help="serial port of this computer at the other end of a "
                                                                "UART link")
    _add_settings(verb)


def _add_settings(verb: ArgumentParser) -> None:
    settings = verb.add_argument_group("settings for a new board.py")
    settings.add_argument("--link", choices=("uart", "wifi"), default="uart", help="default: uart")
    settings.add_argument("--ssid", help="wifi: the network")
    settings.add_argument("--key", default="", help="wifi: its key; omit for an open network")
    settings.add_argument("--ground", metavar="ADDRESS:PORT", help="wifi: address and port of the ground station")
    settings.add_argument("--set", action="append", default=[], metavar="ENTRY=VALUE",
                          help="any entry of board.py, for example SERVO_PIN=15")
