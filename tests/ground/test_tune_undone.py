"""Whatever `tune` tried is undone on every way out: the old gain flies on, or the operator is told how to set it."""

import os
import signal
import sys
import threading

import pytest

from ground.cli.terminal import tell
from ground.errors import GroundError, VehicleError
from ground.tuning.trial import Trial
from protocol import dialect
from sim_bridge.links.link_settings import LinkSettings

GAIN, OLD = "INNER_P", 1.0
STEP = ("tune", "--delay", "0.2", "--duration", "5", "--step", "+50%", "--yes")
IDENTIFIED = ("TURN_K", "GRAVITY_C", "TURN_OFFSET", "PRED_DELAY", "PRED_RATE", "PRED_SAT", "FF_GAIN", "INNER_P",
              "OUTER_L")


def once_tried(kite, action, name=GAIN, after_s=6.0):
    """Do `action` once `name` has been another value in the firmware for so long."""
    old, step, since = kite.firmware_parameter(name), kite.step, []

    def watched() -> None:
        step()
        if not since and kite.firmware_parameter(name) != old:
            since.append(kite.clock())
        if since and since[0] is not None and kite.clock() - since[0] > after_s:
            since[0] = None
            action()

    kite.step = watched


def interrupt() -> None:
    os.kill(os.getpid(), signal.SIGINT)


def terminate() -> None:
    os.kill(os.getpid(), signal.SIGTERM)


def crash() -> None:
    raise RuntimeError("something that nobody thought of")


@pytest.mark.parametrize(("action", "ends_with"), [(interrupt, KeyboardInterrupt), (terminate, SystemExit),
                                                   (crash, RuntimeError)])
def test_an_interrupted_step_is_undone(flying_kite, operator_of, action, ends_with):
    kite = flying_kite("paper-delay", INNER_P=OLD, loss=0.2)
    once_tried(kite, action)
    operator = operator_of(kite)
    before = signal.getsignal(signal.SIGTERM)
    with pytest.raises(ends_with):
        operator.runs(*STEP)
    assert kite.firmware_parameter(GAIN) == OLD
    assert "INNER_P = 1 restored, acknowledged by the kite" in operator.remarked
    assert signal.getsignal(signal.SIGTERM) is before


@pytest.mark.parametrize("command", [("tune", "--yes"), ("tune", "--identify", "--yes")])
def test_an_interrupted_proposal_is_undone_whole(flying_kite, operator_of, command):
    kite = flying_kite("small-kite-paper", INNER_P=OLD, FF_GAIN=0.0)
    before = {name: kite.firmware_parameter(name) for name in IDENTIFIED}
    once_tried(kite, interrupt)
    with pytest.raises(KeyboardInterrupt):
        operator_of(kite).runs(*command)
    assert {name: kite.firmware_parameter(name) for name in IDENTIFIED} == before


def test_a_second_interruption_does_not_stop_the_undoing(flying_kite, operator_of):
    """Nothing gets through while the first is answered; the second comes meanwhile, and is told to wait."""
    kite = flying_kite("paper-delay", INNER_P=OLD)
    good, gone = LinkSettings(delay_s=0.05), LinkSettings(loss=1.0)

    def interrupt_twice() -> None:
        kite.change_link(gone, gone)
        end_s, step = kite.clock() + 3.0, kite.step

        def again() -> None:
            step()
            if kite.clock() >= end_s and kite.step is again:
                kite.step = step
                kite.change_link(good, good)
                interrupt()

        kite.step = again
        interrupt()

    once_tried(kite, interrupt_twice)
    operator = operator_of(kite)
    with pytest.raises(KeyboardInterrupt):
        operator.runs(*STEP)
    assert "restoring the old values: please wait" in operator.remarked
    assert kite.firmware_parameter(GAIN) == OLD


def test_a_link_that_comes_back_in_time_brings_the_old_gain_back(flying_kite, operator_of):
    kite = flying_kite("paper-delay", INNER_P=OLD)
    good, gone = LinkSettings(delay_s=0.05), LinkSettings(loss=1.0)

    def cut() -> None:
        kite.change_link(gone, gone)
        end_s, step = kite.clock() + 25.0, kite.step

        def watched() -> None:
            step()
            if kite.clock() >= end_s and kite.step is watched:
                kite.step = step
                kite.change_link(good, good)

        kite.step = watched

    once_tried(kite, cut)
    operator = operator_of(kite)
    with pytest.raises(GroundError):
        operator.runs(*STEP)
    assert "INNER_P = 1 restored, acknowledged by the kite" in operator.remarked
    assert kite.firmware_parameter(GAIN) == OLD


def test_what_cannot_be_undone_is_said_with_the_command_that_does_it(flying_kite, operator_of):
    kite = flying_kite("paper-delay", INNER_P=OLD)
    once_tried(kite, lambda: kite.change_link(LinkSettings(loss=1.0), LinkSettings(loss=1.0)))
    operator = operator_of(kite)
    with pytest.raises(GroundError):
        operator.runs(*STEP)
    (shouted,) = [line for line in operator.remarked.splitlines() if line.startswith("NOT UNDONE")]
    assert shouted == ("NOT UNDONE, not acknowledged by the kite: INNER_P (tried: 1.5); when it is heard again, "
                       "run: kite-ground param set INNER_P 1")
    assert kite.firmware_parameter(GAIN) == 1.5
    kite.change_link(LinkSettings(delay_s=0.05), LinkSettings(delay_s=0.05))
    with pytest.raises(VehicleError, match=r"^NOT UNDONE"), Trial(kite.session(tell)) as trial:
        trial.set(GAIN, 1.25)
        kite.change_link(LinkSettings(loss=1.0), LinkSettings(loss=1.0))


@pytest.mark.parametrize(("answer", "gain"), [("y\nn\n", OLD), ("y\n", OLD), ("y\ny\n", 1.5)])
def test_only_a_yes_keeps_what_was_tried(flying_kite, operator_of, monkeypatch, tmp_path, answer, gain):
    """The first answer lets it be tried, the second keeps it; none, or the input's end, is no."""
    (tmp_path / "answers").write_text(answer)
    kite = flying_kite("paper-delay", INNER_P=OLD)
    with (tmp_path / "answers").open() as answers:
        monkeypatch.setattr(sys, "stdin", answers)
        assert operator_of(kite).runs(*STEP[:-1]) == 0
    assert kite.firmware_parameter(GAIN) == gain


def test_a_kite_that_is_parked_meanwhile_gets_its_old_gain_back(flying_kite, operator_of):
    """Another station parks it: measurement discarded, and what was tried must not stay."""
    kite = flying_kite("paper-delay", INNER_P=OLD)
    packer = dialect.MAVLink(None, 254, 190)

    def park() -> None:
        kite.radios[0].send(dialect.MAVLink_command_long_message(
            1, 1, dialect.MAV_CMD_DO_SET_MODE, 0, 1.0, float(dialect.KITE_MODE_PARK), 0, 0, 0, 0, 0).pack(packer))

    once_tried(kite, park)
    operator_of(kite).is_told(GroundError, "from TRACK to PARK", *STEP)
    assert kite.firmware_parameter(GAIN) == OLD


def test_identified_settings_that_make_the_flight_run_away_are_undone_at_once(flying_kite, operator_of, monkeypatch):
    """Settings of the wrong sign stand for an identification that went wrong."""
    kite = flying_kite("small-kite-paper")
    before = {name: kite.firmware_parameter(name) for name in IDENTIFIED}
    monkeypatch.setattr("ground.cli.identify.propose", lambda *inputs: {
        "TURN_K": 0.3, "PRED_DELAY": 0.9, "INNER_P": 30.0})
    operator = operator_of(kite)
    assert operator.runs("tune", "--identify", "--yes") == 0
    assert "the flight diverged" in operator.remarked and "old values restored" in operator.said
    assert {name: kite.firmware_parameter(name) for name in IDENTIFIED} == before
    assert kite.clock() < 2.0 + 5.0 + 40.0 + 25.0


def test_a_trial_in_a_thread_of_its_own_is_undone_too(flying_kite):
    """Signals belong to the main thread; exceptions to all."""
    kite = flying_kite("paper-delay", INNER_P=OLD)
    session = kite.session(tell)

    def try_out() -> None:
        try:
            with Trial(session) as trial:
                trial.set(GAIN, 2.0)
                raise RuntimeError
        except RuntimeError:
            pass

    thread = threading.Thread(target=try_out)
    thread.start()
    thread.join()
    assert kite.firmware_parameter(GAIN) == OLD
