"""The files of a board, laid out in a folder: complete, with settings that hold, and they boot."""

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from protocol import dialect
from sim_bridge.boards import module_order, package_listing
from sim_bridge.boards.image import board_settings, check_board_settings, lay_out, read_entries
from sim_bridge.cli.main import main
from sim_bridge.errors import BoardError
from sim_bridge.runtimes.interpreter import micropython_command

ROOT = Path(__file__).parent.parent.parent
TYPES = {f"firmware_py/{name}" for name in (  # alone: no board needs them
    "control/interface", "drivers/interface", "mavlink/interface", "sample", "transports/interface")}
SOURCES = {str(path.with_suffix("").relative_to(ROOT)) for path in (ROOT / "firmware_py").rglob("*.py")}
FIRMWARE = sorted(SOURCES - TYPES)
SERVED = [str(path.relative_to(ROOT)) for path in (ROOT / "firmware_py").rglob("*.json")]
needs_micropython = pytest.mark.skipif(not micropython_command(), reason="needs MicroPython's unix port")


def boot(folder: Path, *script: str) -> list[str]:
    """What a board says when its files lie in `folder` and MicroPython runs `script`."""
    done = subprocess.run([str(micropython_command()), "-X", "heapsize=246k", *script], cwd=folder, text=True,
                          capture_output=True, timeout=60, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return (done.stdout + done.stderr).splitlines()


@pytest.mark.parametrize(("architecture", "ending"), [(None, "py"), ("armv6m", "mpy"), ("xtensawin", "mpy")])
def test_an_image_holds_the_whole_firmware_its_start_and_settings(tmp_path, architecture, ending):
    files = lay_out(tmp_path / "new" / "board", {}, architecture)
    names = sorted([*(f"{name}.{ending}" for name in FIRMWARE), *SERVED])
    assert len(SERVED) == 2 and files == ["main.py", "board.py", *names]
    there = {str(path.relative_to(tmp_path / "new" / "board")) for path in tmp_path.rglob("*") if path.is_file()}
    assert there == set(files)
    assert "\n    import firmware_py.start\n" in (tmp_path / "new" / "board" / "main.py").read_text()


def test_a_second_time_board_py_is_kept_and_old_files_are_gone(tmp_path):
    lay_out(tmp_path, {}, None)
    (tmp_path / "board.py").write_text("LINK = 'mine'\n")
    lay_out(tmp_path, {}, "armv6m")
    assert (tmp_path / "board.py").read_text() == "LINK = 'mine'\n"
    assert not list((tmp_path / "firmware_py").rglob("*.py"))  # MicroPython would prefer them to the new .mpy


def test_the_template_holds_good_settings_and_takes_others():
    plain = read_entries(board_settings({}))
    assert plain is not None and (plain["LINK"], plain["UART_BAUD"], plain["SENSORS"]) == ("uart", 115200, "hil")
    check_board_settings(board_settings({}), "rp2")
    radio = {"LINK": "wifi", "WIFI_SSID": 'the "kite"\\', "WIFI_KEY": "", "GROUND": "10.0.0.2:14550", "SERVO_PIN": 15}
    text = board_settings(radio)
    assert read_entries(text) == plain | radio
    check_board_settings(text, "rp2")
    assert text.count("LINK =") == 1 and text.count("\n") == board_settings({}).count("\n")
    with pytest.raises(BoardError, match="SERVO_PINN is not a setting"):
        board_settings({"SERVO_PINN": 15})


def test_an_esp32_gets_settings_of_its_own_that_hold(capsys, tmp_path):
    """Also where the encoders are taken from the comments as they are."""
    assert main(["board-image", str(tmp_path), "--platform", "esp32"]) == 0
    text = (tmp_path / "board.py").read_text()
    told = read_entries(text)
    assert told is not None and (told["UART"], told["UART_TX"], told["UART_RX"]) == (2, 17, 16)
    flying = text.replace("# AZIMUTH", "AZIMUTH").replace("# ELEVATION", "ELEVATION").replace("# LIGHT", "LIGHT")
    flying = flying.replace('SENSORS = "hil"', 'SENSORS = "line-angles"').replace("SERVO_PIN = None", "SERVO_PIN = 13")
    check_board_settings(flying, "esp32")
    pins = read_entries(flying) or {}
    used = {pins[name][pin] for name in ("AZIMUTH", "ELEVATION") for pin in ("sda", "scl")}
    assert not used & set(range(6, 12))  # where an ESP32's flash is


def test_settings_are_judged_from_here_where_that_is_possible():
    with pytest.raises(BoardError, match=r"board.py: UART is missing: .* \(and 3 more\)"):
        check_board_settings('LINK = "uart"\n', "rp2")
    check_board_settings("import secrets\nLINK = secrets.link\n", "rp2")  # only the board can tell
    check_board_settings("LINK = \n", "rp2")


def run(capsys, *arguments: str) -> tuple[int, str, str]:
    code = main(arguments)
    out, err = capsys.readouterr()
    return code, out, err


def test_the_command_says_what_it_made_and_what_is_wrong_in_one_line(capsys, tmp_path):
    code, out, _ = run(capsys, "board-image", str(tmp_path / "a"), "--json")
    said = json.loads(out)
    assert code == 0 and len(said["files"]) == len(FIRMWARE) + len(SERVED) + 2 and said["bytes"] < 120_000
    code, out, _ = run(capsys, "board-image", str(tmp_path / "a"))
    assert code == 0 and "existing board.py kept" in out
    (tmp_path / "file").write_text("")
    for arguments, says in (
        ([str(tmp_path / "b"), "--arch", "z80"], "mpy-cross for z80"),
        ([str(tmp_path / "file")], "file"),
        ([str(tmp_path / "b"), "--link", "wifi"], "needs --ssid"),
        ([str(tmp_path / "b"), "--link", "wifi", "--ssid", "x", "--ground", "here"], "GROUND = 'here' is wrong: write"),
        ([str(tmp_path / "b"), "--set", "SERVO_PIN"], "write ENTRY=VALUE"),
        ([str(tmp_path / "b"), "--set", "SERVO_PIN=99"], "SERVO_PIN = 99 is wrong"),
        ([str(tmp_path / "b"), "--set", "SERVO_PINN=9"], "SERVO_PINN is not a setting of board.py; did you mean SERVO"),
        ([str(tmp_path / "b"), "--platform", "esp32", "--set", "UART=0"], "UART = 0 is wrong"),
    ):  # fmt: skip
        code, _, err = run(capsys, "board-image", *arguments)
        assert code == 2 and says in err and len(err.splitlines()) == 1, err


@needs_micropython
@pytest.mark.parametrize("architecture", [None, "x64"])
def test_it_boots_as_far_as_a_pc_can_and_tells_what_is_missing_in_one_line(tmp_path, architecture):
    lay_out(tmp_path, {}, architecture)
    assert boot(tmp_path, "main.py") == ["kitepilot: no board module for platform linux: there are rp2 and esp32"]
    (tmp_path / "board.py").write_text('LINK = "uart"\nUART = 0\nUART_TX = 0\nUART_RX = 0\nSENSORS = "hil"\n')
    assert boot(tmp_path, "main.py")[0] == (
        "kitepilot: board.py: UART_TX and UART_RX are both on pin 0: each needs its own")
    (tmp_path / "board.py").write_text("LINK = \n")
    assert boot(tmp_path, "main.py")[0].startswith("kitepilot: board.py: not Python: ")
    (tmp_path / "board.py").unlink()
    assert boot(tmp_path, "main.py")[0] == (
        "kitepilot: board.py: not found: copy the template and enter your settings")


@needs_micropython
def test_on_a_simulated_pico_it_beats_its_heart_and_takes_a_parameter(tmp_path):
    lay_out(tmp_path, {"SYSTEM_ID": 9}, "x64")
    station = dialect.MAVLink(None, srcSystem=255, srcComponent=190)
    request = dialect.MAVLink_param_set_message(9, 1, b"INNER_P", 2.25, dialect.MAV_PARAM_TYPE_REAL32)
    (tmp_path / "uart.in").write_bytes(request.pack(station))
    shutil.copy(Path(__file__).parent / "pico_on_a_pc.py", tmp_path)
    for module in ("socket", "network", "ssl", "asyncio", "esp32"):  # a plain Pico has none of them
        (tmp_path / f"{module}.py").write_text(f'raise ImportError("no module named {module!r}")\n')
    said = boot(tmp_path, "pico_on_a_pc.py")
    assert said[0] == "kitepilot: flying in 2 s; Ctrl-C stops"
    assert said[1:] == ["kitepilot: running as system 9, link uart, sensors hil",
                        "kitepilot: stopped by Ctrl-C; machine.reset() starts again"]
    parser = dialect.MAVLink(None)
    heard: list[Any] = parser.parse_buffer((tmp_path / "uart.out").read_bytes()) or []
    beats = [message for message in heard if message.get_type() == "HEARTBEAT"]
    values = [message for message in heard if message.get_type() == "PARAM_VALUE"]
    assert len(beats) == 8 and {message.get_srcSystem() for message in heard} == {9}
    assert [(value.param_id, value.param_value) for value in values] == [("INNER_P", 2.25)]
    assert (tmp_path / "kitepilot").is_dir()  # and it was saved


def test_the_order_of_modules_is_that_of_the_imports():
    assert module_order.TARGET.read_text("utf-8") == module_order.render()
    order = module_order.render().split('"')[-2].split()
    places = [order.index(name) for name in ("clock", "estimation.estimator", "autopilot", "startup")]
    assert places == sorted(places)


def test_package_json_lists_exactly_the_firmware():
    """Written by `make generate`."""
    text = (ROOT / "package.json").read_text("utf-8")
    assert text == package_listing.render()
    urls = json.loads(text)["urls"]
    names = [*(f"{name}.py" for name in FIRMWARE), *SERVED]
    assert urls == [[name, name] for name in names]
    assert all((ROOT / source).is_file() for _, source in urls)
