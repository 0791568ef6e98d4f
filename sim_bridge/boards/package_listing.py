"""Writes package.json, from which `mpremote mip install` takes the firmware.

    python -m sim_bridge.boards.package_listing
"""

import json
from pathlib import Path

from sim_bridge.boards.image import package_listing


def render() -> str:
    """The text of package.json."""
    return json.dumps(package_listing(), indent=2) + "\n"


if __name__ == "__main__":
    (Path(__file__).parent.parent.parent / "package.json").write_text(render(), "utf-8")
