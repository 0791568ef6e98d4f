"""The tests in on_target/ run a second time here, under MicroPython; and the runner that does it is tested."""

import subprocess
from pathlib import Path

import pytest

from sim_bridge.runtimes.interpreter import micropython_command

HERE = Path(__file__).parent
ROOT = HERE.parent.parent
ON_TARGET = sorted((HERE / "on_target").glob("test_*.py"))
needs_micropython = pytest.mark.skipif(not micropython_command(), reason="no MicroPython interpreter")


def run(*files):
    command = [str(micropython_command()), "-X", "heapsize=2m", str(HERE / "run_on_micropython.py"), str(ROOT)]
    return subprocess.run([*command, *map(str, files)], capture_output=True, text=True, check=False)


@needs_micropython
@pytest.mark.parametrize("path", ON_TARGET, ids=lambda path: path.stem)
def test_on_target(path):
    done = run(path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert " passed, 0 failed" in done.stdout


@needs_micropython
@pytest.mark.parametrize(("text", "says"), [
    ("def test_a():\n    pass\n\ndef test_b():\n    assert 1 == 2\n", "2 passed, 1 failed"),
    ("def test_a():\n    raise ValueError('x')\n", "ValueError: x"),
    ("def nothing():\n    pass\n", "has no tests"),
    ("import no_such_module\n\ndef test_a():\n    pass\n", "cannot be loaded"),
    ("def test_a(:\n", "SyntaxError"),
])
def test_the_runner_does_not_pass_what_fails(tmp_path, text, says):
    bad = tmp_path / "test_bad.py"
    bad.write_text(text)
    good = tmp_path / "test_good.py"
    good.write_text("def test_fine():\n    pass\n")
    done = run(good, bad)
    assert done.returncode == 1 and says in done.stdout


@needs_micropython
def test_the_runner_does_not_pass_nothing():
    assert run().returncode == 1
