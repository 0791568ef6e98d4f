"""Flashing: what would be done, in which order, and what is said when the board is not as it must be.

There is no board here: `mpremote` is a script that answers as told.
"""

import hashlib
import os
import socket
import sys
import threading
from pathlib import Path

import pytest

from protocol import dialect
from sim_bridge.boards.first_heartbeat import wait_for_heartbeat
from sim_bridge.boards.flash import check_room, make_plan
from sim_bridge.boards.image import board_settings, lay_out
from sim_bridge.boards.probe import OnBoard, Probe, read_probe
from sim_bridge.cli.main import main
from sim_bridge.errors import BoardError

PROBE = "kitepilot-probe rp2 micropython 1 28\nfree 4096 200\n"


@pytest.fixture
def mpremote(monkeypatch, tmp_path):
    """Installs a stand-in that prints `says` for a probe and exits with `code`; returns what it was asked."""

    def install(says: str = PROBE, code: int = 0, board_py: str = "") -> Path:
        (tmp_path / "says").write_text(says)
        (tmp_path / "board").write_text(board_py)
        calls = tmp_path / "calls"
        calls.write_text("")
        script = tmp_path / "mpremote"
        script.write_text(
            f"#!{sys.executable}\n"
            "import sys\nfrom pathlib import Path\n"
            f"here = Path({str(tmp_path)!r})\n"
            "with (here / 'calls').open('a') as calls:\n"
            "    words = [word.split('/')[-1] if word[0] == '/' else word for word in sys.argv[4:]]\n"
            "    calls.write(' '.join(words) + '\\n')\n"
            "print((here / ('board' if 'cat' in sys.argv else 'says')).read_text())\n"
            f"sys.exit({code})\n")
        script.chmod(0o755)
        monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
        return calls

    return install


def run(capsys, *arguments: str) -> tuple[int, str, str]:
    code = main(("flash", *arguments))
    out, err = capsys.readouterr()
    return code, out, err


def test_a_dry_run_shows_the_plan_and_needs_no_board(capsys, monkeypatch):
    monkeypatch.setenv("PATH", "")
    code, out, err = run(capsys, "/dev/ttyACM0", "--dry-run")
    lines = out.splitlines()
    assert code == 0 and not err
    commands = [line for line in lines if line.startswith("mpremote connect /dev/ttyACM0 resume ")]
    copied = " ".join(commands)
    sources = [path for path in Path("firmware_py").rglob("*.py") if path.name not in ("interface.py", "sample.py")]
    assert len(sources) > 60 and all(str(path.with_suffix(".mpy")) in copied for path in sources)
    assert [command.split()[-1] for command in commands[-3:]] == [":board.py", ":main.py", "reset"]
    assert lines[-1] == "dry run for an empty Pico: nothing was changed"


def test_an_empty_board_gets_everything_and_main_py_last(capsys, mpremote):
    calls = mpremote()
    code, out, _ = run(capsys, "/dev/ttyACM0")
    done = calls.read_text().splitlines()
    copies = [line for line in done if line.startswith("fs cp")]
    assert code == 0 and "0 up to date" in out and "LISTEN=" in out
    assert out.startswith("nothing of kitepilot on this board: it is new, or has lost its file system")
    assert copies[-2:] == ["fs cp board.py :board.py", "fs cp main.py :main.py"] and done[-1] == "reset"
    assert {line.split()[-1] for line in copies[:-2]} == {
        f":{path.as_posix()}/" for path in Path("firmware_py").rglob("*") if any(path.glob("*.py"))} | {":firmware_py/"}


def board_with(image: Path, files: list[str], **changed: str) -> str:
    """What a board with this image on it answers to a probe; `changed` files hold something else."""
    rows = []
    for name in files:
        digest = changed.get(Path(name).stem, hashlib.sha256((image / name).read_bytes()).hexdigest())
        rows.append(f"file {(image / name).stat().st_size} {digest} {name}")
    return PROBE + "\n".join(rows) + "\n"


def test_only_what_changed_is_copied_and_board_py_never_over_another(capsys, mpremote, tmp_path):
    image = tmp_path / "image"
    files = lay_out(image, {}, "armv6m")
    mine = board_settings({"SYSTEM_ID": 5})
    says = board_with(image, files, estimator="0" * 64, board="1" * 64) + f"file 9 {'2' * 64} firmware_py/old.py\n"
    calls = mpremote(says, board_py=mine)
    code, out, _ = run(capsys, "/dev/ttyACM0")
    done = calls.read_text().splitlines()
    assert code == 0 and f"1 files to copy, {len(files) - 1} up to date, 1 to remove" in out
    assert [line for line in done if line.startswith("fs")] == [
        "fs cat :board.py", "fs rm :firmware_py/old.py", "fs cp estimator.mpy :firmware_py/estimation/"]


@pytest.mark.parametrize(("says", "code", "expected"), [
    ("mpremote: failed to access /dev/x (it may be in use by another program)", 1, "no board there, or"),
    ("Traceback\nmpremote.transport.TransportError: could not enter raw repl", 1, "no MicroPython answers"),
    ("OSError: [Errno 28] ENOSPC", 1, "no room on the board"),
    ("something\nelse went wrong", 1, "else went wrong"), ("", 1, "mpremote failed"),
    ("hello", 0, "no MicroPython answers"),
    ("kitepilot-probe rp2 circuitpython 9 1\n", 0, "no MicroPython answers"),
    ("kitepilot-probe rp2 micropython 1 27\nfree 4096 200\n", 0, "MicroPython 1.27 on the board is too old: 1.28"),
    ("kitepilot-probe stm32 micropython 1 28\nfree 4096 200\n", 0, "there is no board module for stm32"),
    ("kitepilot-probe rp2 micropython 1 28\nfree 4096 3\n", 0, "no room on the board: "),
    ("kitepilot-probe rp2 micropython 1 28\nno-file-system\n", 0, "can neither read its flash nor format it"),
])  # fmt: skip
def test_what_is_wrong_with_a_board_is_said_in_one_line(capsys, mpremote, says, code, expected):
    calls = mpremote(says, code)
    exit_code, _, err = run(capsys, "/dev/ttyACM0")
    assert exit_code == 2 and expected in err and len(err.splitlines()) == 1, err
    assert "reset" not in calls.read_text()


def test_an_esp32_gets_a_uart_that_is_not_its_console(capsys, mpremote):
    calls = mpremote(PROBE.replace("rp2", "esp32"))
    assert run(capsys, "/dev/ttyUSB0")[0] == 0 and calls.read_text().splitlines()[-1] == "reset"
    code, _, err = run(capsys, "/dev/ttyUSB0", "--set", "UART=0")
    assert code == 2 and "UART = 0 is wrong: write a whole number from 1 to 2" in err


def test_bad_settings_on_the_board_are_said_instead_of_waiting_for_it(capsys, mpremote):
    calls = mpremote(PROBE + f"file 9 {'1' * 64} board.py\n", board_py='LINK = "wifi"\nSENSORS = "hil"\n')
    code, _, err = run(capsys, "/dev/ttyACM0")
    assert code == 2 and "board.py: WIFI_SSID is missing" in err and "(and 2 more)" in err
    assert "reset" not in calls.read_text()


def test_no_port_is_said_as_make_would_have_it(capsys):
    code, _, err = run(capsys, "")
    assert code == 2 and "make flash PORT=" in err


def test_room_counts_whole_blocks_and_what_is_replaced(tmp_path):
    (tmp_path / "a.mpy").write_bytes(bytes(4097))
    there = {"a.mpy": OnBoard(100, "x"), "firmware_py/old.py": OnBoard(1, "y")}
    for free, files, fits in ((2, {}, True), (1, {}, False), (1, there, True), (0, there, True)):
        probe = Probe("rp2", (1, 28), 4096, free * 4096, files)
        plan = make_plan(tmp_path, ["a.mpy"], probe)
        assert plan.copy == ["a.mpy"]
        if fits:
            check_room(tmp_path, plan, probe)
        else:
            with pytest.raises(BoardError, match="8 KB are needed, 4 KB are free"):
                check_room(tmp_path, plan, probe)


def test_a_probe_is_read_past_what_else_the_board_says():
    probe = read_probe("hello\nkitepilot-probe rp2 micropython 1 29\nfree 4096 10\nfile 7 abc main.py\nbye\n")
    assert probe == Probe("rp2", (1, 29), 4096, 40960, {"main.py": OnBoard(7, "abc")})


def test_the_first_heartbeat_is_waited_for_where_the_settings_say():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    settings = board_settings({"LINK": "wifi", "WIFI_SSID": "k", "WIFI_KEY": "", "GROUND": f"127.0.0.1:{port}"})
    said: list[str] = []
    with pytest.raises(BoardError, match=f"no HEARTBEAT on UDP port {port}"):
        wait_for_heartbeat(settings, None, said.append, 0.1)
    board = dialect.MAVLink(None, srcSystem=4)
    beat = dialect.MAVLink_heartbeat_message(dialect.MAV_TYPE_KITE, 0, 1, 0, 3, 3).pack(board)

    def talk(text: str) -> None:
        said.append(text)
        if text.startswith("waiting"):  # the listener is there when this is said, or soon after
            talker.start()

    stop = threading.Event()

    def shout() -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            while not stop.wait(0.05):
                sender.sendto(beat, ("127.0.0.1", port))

    talker = threading.Thread(target=shout)
    wait_for_heartbeat(settings, None, talk)
    stop.set()
    talker.join()
    assert said[-1] == "heard: HEARTBEAT of system 4"


def test_a_serial_port_that_is_not_there_is_one_line():
    with pytest.raises(BoardError, match="/dev/none"):
        wait_for_heartbeat(board_settings({}), "/dev/none:57600", lambda text: None)
