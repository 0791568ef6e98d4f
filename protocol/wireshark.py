"""Write a dissector for Wireshark that knows the kite's messages and those of common.xml.

    python -m protocol.wireshark kite.lua

pymavlink's generator does the work.
"""

import argparse
import contextlib
import io
import shutil
import sys
import tempfile
from pathlib import Path

from pymavlink.generator import mavgen_wlua, mavparse

from protocol.generate import HERE, parse_dialect


def dissector() -> str:
    """The text of the dissector, in Lua."""
    shipped = Path(mavparse.__file__).parent.parent / "dialects" / "v20"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for source in (HERE / "kite.xml", *shipped.glob("*.xml")):  # an include is found beside its file only
            shutil.copy(source, folder)
        files = parse_dialect(folder)
        with contextlib.redirect_stdout(io.StringIO()):
            mavgen_wlua.generate(str(folder / "kite.lua"), files)
        return (folder / "kite.lua").read_text("utf-8")


def main() -> int:
    """Write the dissector where the command line says."""
    parser = argparse.ArgumentParser(prog="python -m protocol.wireshark", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("out", metavar="OUT.lua", type=Path, help="such as ~/.local/lib/wireshark/plugins/kite.lua")
    out = parser.parse_args().out
    try:
        out.write_text(dissector(), "utf-8")
    except OSError as error:
        print(f"{out}: cannot write: {error.strerror}", file=sys.stderr)
        return 2
    print(f"wrote {out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
