"""The verbs of `kite-sitl` for real boards."""

import json
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import Any

from sim_bridge.boards.first_heartbeat import wait_for_heartbeat
from sim_bridge.boards.flash import flash
from sim_bridge.boards.image import ARCHITECTURES, BoardError, lay_out


def add_board_verbs(verbs: Any) -> None:
    """Add `board-image` and `flash` to the parser."""
    image = verbs.add_parser(
        "board-image", help="write a board's files into a folder",
        description="Write main.py, board.py and the compiled firmware into DIR, as they will be on the board. An "
        "existing board.py is kept.")
    image.add_argument("folder", metavar="DIR", help="the folder; created if needed")
    image.add_argument("--platform", choices=tuple(ARCHITECTURES), default="rp2", help="default: rp2")
    image.add_argument("--arch", metavar="ARCH", help="architecture for mpy-cross (default: the platform's)")
    image.add_argument("--source", action="store_true", help="the firmware as .py instead of .mpy")
    image.add_argument("--json", action="store_true", help="print JSON for a script")
    image.set_defaults(do=board_image)
    upload = verbs.add_parser(
        "flash", help="install the firmware on a board",
        description="Copy the changed files to the board at PORT with mpremote, write board.py if there is none, "
        "restart the board and wait for its first HEARTBEAT.")
    upload.add_argument("port", metavar="PORT", help="serial port of the board's console; `mpremote connect list`")
    upload.add_argument("--dry-run", action="store_true", help="show what would be done to an empty Pico; change "
                                                               "nothing")
    upload.add_argument("--listen", metavar="DEVICE[:BAUD]", help="serial port of this computer at the other end of a "
                                                                  "UART link")
    upload.set_defaults(do=flash_board)
    for verb in (image, upload):
        _add_settings(verb)


def _add_settings(verb: ArgumentParser) -> None:
    settings = verb.add_argument_group("settings for a new board.py")
    settings.add_argument("--link", choices=("uart", "wifi"), default="uart", help="default: uart")
    settings.add_argument("--ssid", help="wifi: the network")
    settings.add_argument("--key", default="", help="wifi: its key; omit for an open network")
    settings.add_argument("--ground", metavar="ADDRESS:PORT", help="wifi: address and port of the ground station")
    settings.add_argument("--set", action="append", default=[], metavar="ENTRY=VALUE",
                          help="any entry of board.py, for example SERVO_PIN=15")


def board_image(options: Namespace) -> int:
    """`kite-sitl board-image`."""
    architecture = None if options.source else options.arch or ARCHITECTURES[options.platform]
    folder = Path(options.folder)
    kept = (folder / "board.py").exists()
    files = lay_out(folder, _entries(options), architecture, options.platform)
    size = sum((folder / name).stat().st_size for name in files)
    if options.json:
        print(json.dumps({"folder": str(folder), "files": files, "bytes": size, "kept_board_py": kept}))
    else:
        note = "; existing board.py kept" if kept else ""
        print(f"{len(files)} files, {size // 1024} KB in {folder}{note}")
    return 0


def flash_board(options: Namespace) -> int:
    """`kite-sitl flash`."""
    if not options.port:
        raise BoardError("which board? make flash PORT=/dev/ttyACM0; `mpremote connect list` shows the ports")

    def say(text: str) -> None:
        print(text, flush=True)

    settings = flash(options.port, _entries(options), say, options.dry_run)
    if options.dry_run:
        say("dry run for an empty Pico: nothing was changed")
    else:
        wait_for_heartbeat(settings, options.listen, say)
    return 0


def _entries(options: Namespace) -> dict[str, Any]:
    entries: dict[str, Any] = {"LINK": options.link}
    if options.link == "wifi":
        if not options.ssid or not options.ground:
            raise BoardError("--link wifi needs --ssid NAME and --ground ADDRESS:PORT, and --key unless the network "
                             "is open")
        entries |= {"WIFI_SSID": options.ssid, "WIFI_KEY": options.key, "GROUND": options.ground}
    for assignment in options.set:
        name, equals, text = assignment.partition("=")
        if not equals:
            raise BoardError(f"--set {assignment}: write ENTRY=VALUE")
        entries[name] = _value(text)
    return entries


def _value(text: str) -> Any:
    """A number, None, or text."""
    if text == "None":
        return None
    try:
        return int(text)
    except ValueError:
        return text
