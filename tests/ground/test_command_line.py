"""kite-ground without a vehicle: every mistake is answered in one line that says what would be right."""

import contextlib
import signal
import socket
import subprocess
import sys

import pytest

from ground.cli.main import main


@pytest.fixture
def taken():
    """A port that another program listens on."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        yield other.getsockname()[1]


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as plain:
        plain.bind(("127.0.0.1", 0))
        return plain.getsockname()[1]


@pytest.mark.parametrize(("arguments", "said"), [
    ("", "VERB"),
    ("fly", "no verb 'fly'; there are monitor, mode,"),
    ("montior", "no verb 'montior'; did you mean monitor?"),
    ("param sett INNER_P 2", "no verb 'sett'; did you mean set?"),
    ("param show --jsn", "--jsn is not an option; did you mean --json?"),
    ("--system 300 monitor", "300 is outside 1 to 255"),
    ("mode loiter", "'loiter' is not one of standby, manual, park, track"),
    ("tune --step 5x", "'5x' is not a step: write +10% or -5%"),
    ("tune --step +150%", "must be from -90% to +100%, and not 0"),
    ("tune --step -95%", "must be from -90% to +100%, and not 0"),
    ("tune --delay -0.2", "'-0.2' must be more than 0"),
    ("tune --delay soon", "'soon' is not a number"),
    ("--timeout 0 monitor", "'0' must be more than 0"),
    ("--link tcp:1.2.3.4:5 monitor", "must be udpin:HOST:PORT, udpout:HOST:PORT or serial:DEVICE:BAUD"),
    ("monitor --link serial:/dev/no_such_port:57600", "no such device"),
    ("param", "VERB"),
    ("param get INNER_Q", "no parameter is called 'INNER_Q'; did you mean INNER_P?"),
    ("param set steer_rat 2", "'steer_rat'; did you mean STEER_RATE?"),
    ("param set INNER_P fast", "INNER_P: 'fast' is not a number"),
    ("param set INNER_P inf", "INNER_P: 'inf' is not a finite number"),
    ("param load no_such.param", "no_such.param: cannot read: No such file"),
])
def test_a_mistake_is_answered_in_one_line(capsys, arguments, said):
    assert main(arguments.split()) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert said in output.err and output.err.count("\n") == 1 and output.err.startswith("kite-ground")


def test_a_broken_file_is_named_before_anything_is_opened(capsys, tmp_path):
    path = tmp_path / "broken.param"
    for content, said in (("INNER_P 1.5\nOUTER_L\n", ":2: 'OUTER_L' is not a parameter"),
                          ("INNER_P 1.5\nOUTER_L 51\n", ":2: OUTER_L = 51 is outside 0 to 50; nothing was set")):
        path.write_text(content)
        assert main(["param", "load", str(path), "--link", "serial:/dev/no_such_port:57600"]) == 2
        error = capsys.readouterr().err
        assert f"{path}{said}" in error and error.count("\n") == 1


def test_a_port_in_use_is_named(capsys, taken):
    assert main(["--link", f"udpin:127.0.0.1:{taken}", "arm"]) == 2
    error = capsys.readouterr().err
    assert f"port {taken}: another program is listening there" in error and error.count("\n") == 1


def test_no_heartbeat_says_what_was_listened_to_and_what_to_check(capsys):
    link = f"udpin:127.0.0.1:{free_port()}"
    assert main(["--link", link, "param", "show", "--timeout", "0.2"]) == 2
    error = capsys.readouterr().err
    assert error == (f"kite-ground: no heartbeat within 0.2 s on {link}: is the kite running, and does it send to "
                     "this address and port?\n")


@pytest.fixture
def called():
    """Starts kite-ground calling a socket of ours; gives the process, the socket, and where it called from."""
    with contextlib.ExitStack() as stack:
        def start(*arguments: str):
            ours = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            ours.bind(("127.0.0.1", 0))
            command = [sys.executable, "-c", "import signal, sys; from ground.cli.main import main; "
                       "signal.signal(signal.SIGINT, signal.default_int_handler); "  # ignored in a background job
                       "sys.exit(main())",
                       "--link", f"udpout:127.0.0.1:{ours.getsockname()[1]}", *arguments]
            process = stack.enter_context(subprocess.Popen(command, stderr=subprocess.PIPE, text=True))
            return process, ours, ours.recvfrom(500)[1]

        yield start


def test_bytes_that_are_no_vehicle_are_told_apart_from_silence(called):
    """Another ground station, or the wrong baud rate, comes to us as bytes without a vehicle's heartbeat."""
    process, ours, caller = called("--timeout", "1", "monitor")
    ours.sendto(b"no MAVLink at all", caller)
    _, error = process.communicate()
    assert process.returncode == 2
    assert "no heartbeat within 1 s" in error and "17 bytes came: is that MAVLink" in error and error.count("\n") == 1


def test_ctrl_c_ends_without_a_traceback(called):
    process, _, _ = called("--timeout", "1000", "arm")
    process.send_signal(signal.SIGINT)
    _, error = process.communicate()
    assert process.returncode == 130
    assert "Traceback" not in error and "interrupted" in error


@pytest.mark.parametrize("command", ["", "monitor", "mode", "arm", "disarm", "tune", "record", "param", "param show",
                                     "param get", "param set", "param save", "param savechanged", "param load",
                                     "param diff", "param revert", "param snapshot", "param watch", "completion"])
def test_every_command_has_help_with_an_example(capsys, command):
    assert main([*command.split(), "--help"]) == 0
    text = capsys.readouterr().out
    assert "--link" in text and (command == "param" or "kite-ground --link" in text or f"kite-ground {command}" in text)
