"""The verbs of `kite-sitl` for real boards."""

import json
from argparse import Namespace
from pathlib import Path
from typing import Any

from sim_bridge.boards.architectures import ARCHITECTURES
from sim_bridge.boards.first_heartbeat import wait_for_heartbeat
from sim_bridge.boards.flash import flash
from sim_bridge.boards.image import lay_out
from sim_bridge.errors import BoardError


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
