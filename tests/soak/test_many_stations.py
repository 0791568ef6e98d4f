"""Ground stations by the hundred against one simulator: real programs, real sockets, real time."""

import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

pytestmark = pytest.mark.soak

BIN = Path(sys.executable).parent
IN_A_ROW, AT_ONCE = 500, 20


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@pytest.fixture
def simulator() -> Iterator[str]:
    """A kite in flight; the link by which ground stations come to it."""
    listen, send_to = free_port(), free_port()
    command = [str(BIN / "kite-sitl"), "run", "paper-delay-tuned", "--runtime", "cpython", "--speed", "1", "--ground",
               "--forever", "--set", f"ground.listen=127.0.0.1:{listen}",
               "--set", f"ground.send_to=127.0.0.1:{send_to}", "--status"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        while "TRACK" not in process.stdout.readline():
            assert process.poll() is None
        drain = subprocess.Popen(["cat"], stdin=process.stdout, stdout=subprocess.DEVNULL)
        yield f"udpout:127.0.0.1:{listen}"
        process.terminate()
        process.wait()
        drain.wait()


def ground(link: str, *words: str) -> subprocess.Popen[str]:
    return subprocess.Popen([str(BIN / "kite-ground"), "--link", link, *words], text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def ended(process: subprocess.Popen[str]) -> tuple[int, str]:
    """Exit code and what was said."""
    out, err = process.communicate()
    return process.returncode, out + err


def test_five_hundred_commands_in_a_row_and_twenty_at_once_are_answered(simulator):
    for number in range(IN_A_ROW):
        code, said = ended(ground(simulator, "param", "get", "INNER_P"))
        assert code == 0 and "INNER_P" in said, f"number {number}: {said}"
    together = [ground(simulator, "param", "get", "OUTER_L") for _ in range(AT_ONCE)]
    assert [(code, "OUTER_L" in said) for code, said in map(ended, together)] == [(0, True)] * AT_ONCE
    code, said = ended(ground(simulator, "disarm"))
    assert code == 0, said
    code, said = ended(ground(simulator, "mode"))
    assert code == 0 and "STANDBY" in said
