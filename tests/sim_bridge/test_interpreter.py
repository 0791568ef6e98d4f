"""The MicroPython that the user names: it is asked what it is, gets a firmware it can run, and the log tells of it."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from sim_bridge.boards.image import board_name, compiled_version, firmware_files
from sim_bridge.cli.main import main
from sim_bridge.runs.run import RunOptions, run_scenario
from sim_bridge.runtimes.interpreter import find_interpreter, micropython_command
from sim_bridge.runtimes.process import ProcessRuntime, micropython_and_firmware
from sim_bridge.scenario.scenario import load_scenario

SECONDS = "4"
MPY_6_2 = 6 | 2 << 8  # what `_mpy` is for .mpy files of version 6.2 without native code
FLIGHT = Path(__file__).parent.parent / "data" / "flight" / "20191008_0065.csv.gz"
needs_micropython = pytest.mark.skipif(not micropython_command(), reason="needs MicroPython's unix port")


def program(path: Path, text: str) -> str:
    path.write_text(text)
    path.chmod(0o755)
    return str(path)


def says_it_is(path: Path, answer: str) -> str:
    """MicroPython, but it gives this `answer` when it is asked."""
    return program(path, f"#!/bin/sh\n[ $1 = -c ] && exec echo '{answer}'\nexec {micropython_command()} \"$@\"\n")


def run(capsys, *arguments: str) -> tuple[int, str, str]:
    code = main(arguments)
    out, err = capsys.readouterr()
    return code, out, err


def test_what_is_no_interpreter_here_is_said_in_one_line(capsys, tmp_path):
    plain = tmp_path / "plain"
    plain.write_text("")
    mute = program(tmp_path / "mute", "#!/bin/sh\n")
    foreign = program(tmp_path / "foreign", "\x7fELF of another processor")
    lost = program(tmp_path / "lost", "#!/nowhere/loader\n")
    for path, says in (
        (str(tmp_path / "none"), "no such file"), (str(tmp_path), "not a file"), (str(plain), "not executable"),
        (mute, "not MicroPython"), (sys.executable, "not MicroPython but cpython 3."),
        (foreign, "cannot run on this machine"), (lost, "its libraries are missing"),
    ):  # fmt: skip
        code, out, err = run(capsys, "run", "small-kite", "--runtime", "micropython", "--interpreter", path)
        assert (code, out) == (2, "") and err.startswith(f"kite-sitl: --interpreter {path}: {says}"), err
        assert len(err.splitlines()) == 1


def test_only_micropython_has_an_interpreter(capsys):
    for verb in (["run", "small-kite"], ["run", "small-kite", "--runtime", "cpython"], ["bench"]):
        code, _, err = run(capsys, *verb, "--interpreter", sys.executable)
        assert (code, err) == (2, "kite-sitl: --interpreter: only --runtime micropython has one\n")


def fly(options: RunOptions):
    scenario = load_scenario("small-kite")
    scenario.set("run.duration_s", float(SECONDS), "test")
    return run_scenario(scenario, options)


@needs_micropython
@pytest.mark.parametrize(("answer", "ending", "viper"), [
    ("micropython 1.28.0 {native} 53", ".mpy", True),
    ("micropython 1.28.0 {portable} 53", ".mpy", False),
    ("micropython 1.22.0 {older} 53", ".mpy", False),
    ("micropython 1.28.0 {unknown} 53", ".mpy", False),
    ("micropython 1.18.0 5 53", ".py", True),
    ("micropython 1.28.0 0 53", ".py", True),
])
def test_the_firmware_is_compiled_for_what_the_interpreter_can_run(tmp_path, answer, ending, viper):
    """Native code for its processor if there is any of that version, else bytecode, else sources: the same flight."""
    if find_interpreter().architecture is None:
        pytest.skip("MicroPython has no native code for this machine")
    assert find_interpreter().mpy_version == compiled_version()
    question = "import sys; print(sys.implementation._mpy)"
    native = int(subprocess.check_output([str(micropython_command()), "-c", question]))
    numbers = {"native": native, "portable": native & 0x3FF, "older": native - 0x100, "unknown": native | 0xF << 10}
    path = says_it_is(tmp_path / "interpreter", answer.format(**numbers))
    _, folder = micropython_and_firmware(find_interpreter(path))
    names = {path.relative_to(folder).as_posix() for path in (folder / "firmware_py").rglob(f"*{ending}")}
    wanted = {board_name(path.with_suffix(ending)) for path in firmware_files()}
    assert wanted - names == (set() if viper else {f"firmware_py/mavlink/crc_viper{ending}"})
    flown = fly(RunOptions("micropython", interpreter=path))
    assert isinstance(flown.flight.runtime, ProcessRuntime) and flown.flight.runtime.name == "micropython"
    assert flown.flight.rows == fly(RunOptions()).flight.rows


@needs_micropython
def test_the_log_tells_which_interpreter_flew_and_it_flies_again(capsys, tmp_path):
    """It moves away: another takes its place, which is told; but not one with floats of another width."""
    mine = says_it_is(tmp_path / "mine", f"micropython 1.27.3 {MPY_6_2} 53\nMicroPython v1.27.3 on a day")
    folder = tmp_path / "log"
    assert run(capsys, "run", "small-kite", "--runtime", "micropython", "--interpreter", mine, "--duration", SECONDS,
               "--log", str(folder))[0] == 0
    about = json.loads((folder / "run.json").read_text())
    told = about["interpreter"]
    assert (told["path"], told["version"], told["build"], told["float_bits"]) == (
        mine, "1.27.3", "v1.27.3 on a day", 64)
    code, out, err = run(capsys, "rerun", str(folder))
    assert code == 0 and "the same to the bit" in out and "MicroPython" not in err

    Path(mine).rename(tmp_path / "moved")
    code, out, err = run(capsys, "rerun", str(folder))
    assert code == 0 and "the same to the bit" in out
    assert err.startswith("kite-sitl: flown by MicroPython 1.27.3 (v1.27.3 on a day) with 64-bit floats, now by Micro")
    code, out, err = run(capsys, "rerun", str(folder), "--interpreter", str(tmp_path / "moved"))
    assert code == 0 and "the same to the bit" in out and "MicroPython" not in err

    about["interpreter"]["float_bits"] = 32
    (folder / "run.json").write_text(json.dumps(about))
    code, _, err = run(capsys, "rerun", str(folder))
    assert code == 2 and len(err.splitlines()) == 1 and "with 32-bit floats" in err and "--interpreter PATH" in err
    code, _, err = run(capsys, "rerun", str(folder), "--interpreter", str(tmp_path / "moved"))
    assert code == 0 and "with 32-bit floats, now by" in err


def test_a_flight_without_an_interpreter_logs_none(capsys, tmp_path):
    run(capsys, "run", "small-kite", "--duration", SECONDS, "--log", str(tmp_path / "log"))
    assert json.loads((tmp_path / "log" / "run.json").read_text())["interpreter"] is None


@needs_micropython
def test_a_wrong_path_costs_no_log_folder(capsys, tmp_path):
    arguments = ["run", "small-kite", "--runtime", "micropython", "--duration", SECONDS, "--log", str(tmp_path / "log")]
    assert run(capsys, *arguments, "--interpreter", str(tmp_path / "none"))[0] == 2
    assert run(capsys, *arguments)[0] == 0


@pytest.mark.parametrize("verb", [
    ["bench", "--runtime", "micropython"], ["shadow", "FLIGHT", "--runtime", "micropython"], ["rerun", "LOG"],
    ["run", "small-kite", "--runtime", "micropython", "--speed", "1"]])
def test_every_verb_that_flies_takes_it(capsys, tmp_path, verb: list[str]):
    fly(RunOptions(log=tmp_path / "log"))
    places = {"LOG": str(tmp_path / "log"), "FLIGHT": str(FLIGHT)}
    code, _, err = run(capsys, *(places.get(word, word) for word in verb), "--interpreter", str(tmp_path / "none"))
    lines = err.splitlines()
    assert code == 2 and len(lines) == 1
    assert lines[0].startswith("kite-sitl: --interpreter: only" if verb[0] == "rerun" else "kite-sitl: --interpreter /")
