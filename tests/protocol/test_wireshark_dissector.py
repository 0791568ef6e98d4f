"""The dissector for Wireshark knows every message that the kite speaks."""

import subprocess
import sys

from protocol import dialect


def test_the_dissector_knows_every_message(tmp_path):
    out = tmp_path / "kite.lua"
    subprocess.run([sys.executable, "-m", "protocol.wireshark", str(out)], check=True, capture_output=True)
    text = out.read_text("utf-8")
    for number, kind in dialect.mavlink_map.items():
        assert f"[{number}] = '{kind.msgname}'" in text
        for field in kind.fieldnames:
            assert f"f.{kind.msgname}_{field}" in text
    place = tmp_path / "none" / "kite.lua"
    refused = subprocess.run([sys.executable, "-m", "protocol.wireshark", str(place)], check=False,
                             capture_output=True, text=True)
    assert refused.returncode == 2 and refused.stderr == f"{place}: cannot write: No such file or directory\n"
