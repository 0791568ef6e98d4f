"""kite-sitl design, from its arguments to what it prints and draws."""

import json

import pytest

from kite_analysis.delay.inner_loop import optimal_gain, stability_limit
from sim_bridge.cli.main import main


def designed(capsys, *arguments: str):
    assert main(["design", *arguments, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_the_small_kite_is_designed(capsys, tmp_path):
    arguments = ["--delay", "0.2", "--speed-over-length", "0.45", "--gain-p", "1.75", "--gain-l", "5"]
    numbers = designed(capsys, *arguments)
    whole = numbers["whole_loop"]
    assert numbers["paper"]["limit"] == pytest.approx(stability_limit(0.2))
    assert numbers["paper"]["sampled_optimum"] == pytest.approx(optimal_gain(0.21))
    assert whole["limit"] == pytest.approx(5.2535, abs=1e-3)
    assert whole["present"]["gain_margin"] == pytest.approx(5.2535 / 1.75, rel=1e-3)
    assert whole["present"]["stable"] and 0.0 < whole["present"]["delay_margin_s"] < 0.21
    assert (whole["best"]["inner_p"], whole["best"]["outer_l"]) == pytest.approx((2.172, 1.653), rel=1e-3)
    assert whole["best"]["rate"] == pytest.approx(-2.805, rel=1e-3)
    picture = tmp_path / "new" / "design.png"
    assert main(["design", *arguments, "--plot", str(picture)]) == 0
    said = capsys.readouterr().out
    for number in ("7.854", "7.48", "1.839", "5.254", "10.55", "P = 2.172", "L = 1.653", "2.805 1/s", "3 times P"):
        assert number in said
    assert picture.read_bytes().startswith(b"\x89PNG") and picture.stat().st_size > 20_000


def test_the_papers_optimum_is_called_unstable_where_it_is(capsys):
    arguments = ["--delay", "0.4", "--speed-over-length", "0.45", "--gain-p", "0.92"]
    assert not designed(capsys, *arguments)["whole_loop"]["present"]["stable"]
    assert main(["design", *arguments]) == 0
    said = capsys.readouterr().out
    assert "UNSTABLE" in said and "s too much delay, or P 2.01 times too high" in said


def test_without_any_other_delay_sampling_is_told_exactly(capsys):
    numbers = designed(capsys, "--delay", "0", "--speed-over-length", "0.06")
    assert numbers["paper"]["limit"] is None
    assert numbers["whole_loop"]["limit"] == pytest.approx(stability_limit(0.01), rel=0.01)
    assert numbers["whole_loop"]["sampled_limit"] == pytest.approx(100.0, rel=0.01)  # P T < 2
    assert main(["design", "--delay", "0", "--speed-over-length", "0.06"]) == 0
    assert "(100 exact, with sampling)" in capsys.readouterr().out


def test_jitter_loss_and_lag_cost_gain(capsys):
    arguments = ["--delay", "0.2", "--speed-over-length", "0.45"]
    clean, noisy, slow = (designed(capsys, *arguments, *more)["whole_loop"]["limit"]
                          for more in ((), ("--jitter", "0.01", "--loss", "0.2"), ("--lag", "0.1")))
    assert clean > 1.05 * noisy and clean > 1.2 * slow
    assert main(["design", *arguments, "--loss", "0.2"]) == 0
    assert "make 0.2 s act like 0.21 s" in capsys.readouterr().out


@pytest.mark.parametrize(("arguments", "said"), [
    ("--speed-over-length 0.45", "--delay"),
    ("--delay -1 --speed-over-length 0.45", "-1 must be 0 or more"),
    ("--delay 0.2 --speed-over-length 0", "0 must be more than 0"),
    ("--delay soon --speed-over-length 1", "'soon' is not a number"),
    ("--delay 2 --speed-over-length 1", "kite-sitl: design: speed over length of 1 1/s with 2.01 s of delay"),
    ("--delay 0.2 --speed-over-length 1 --loss 1", "kite-sitl: design: loss of 1: must be at least 0 and below 1"),
])
def test_mistakes_are_answered(capsys, arguments, said):
    try:
        code = main(["design", *arguments.split()])
    except SystemExit as leaving:
        code = leaving.code
    output = capsys.readouterr()
    assert code == 2 and output.out == "" and said in output.err and "Traceback" not in output.err
