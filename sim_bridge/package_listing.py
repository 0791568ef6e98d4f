"""Writes package.json, from which `mpremote mip install` takes the firmware: `python -m sim_bridge.package_listing`."""

import json
from pathlib import Path

from sim_bridge.board_image import package_listing


def render() -> str:
    """The text of package.json."""
    return json.dumps(package_listing(), indent=2) + "\n"


if __name__ == "__main__":
    (Path(__file__).parent.parent / "package.json").write_text(render(), "utf-8")
