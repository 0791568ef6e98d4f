"""kite-ground tune: the delay in the loop, the gains that it allows, and the effect of a gain change on the flight."""

import argparse
import json
import math
import re
from collections.abc import Callable

from ground.cli.identify import identify_and_set
from ground.cli.options import Connect, begin_verb, positive
from ground.cli.snapshot_option import add_snapshot_option, snapshot_store
from ground.cli.terminal import confirm, tell
from ground.errors import GroundError, UsageError
from ground.parameters.file import format_value
from ground.parameters.snapshot import SnapshotStore
from ground.session import Session
from ground.tuning import gain_advice
from ground.tuning.flown_law import FlownAdvice, advise_on, describe_flown, flown_as_dictionary, read_law
from ground.tuning.gain_advice import GAIN_NAME, OUTER_NAME, RATE_NAME, GainAdvice
from ground.tuning.in_flight import (
    DELAY_MEASURE_S,
    DelayReport,
    StepResult,
    TuningFlight,
    parse_step,
)
from ground.tuning.report import delay_as_dictionary, delay_lines, effect_lines, scale_line
from ground.tuning.trial import Trial
from ground.vehicle.history import StateHistory

_SPEED_OPTION = "--speed-over-length"
_POSITION_WAIT_S = 2.0  # for telemetry at about 1 Hz
_LEAST_DELAY_S = 1e-3  # without delay, every gain would do
_GLANCE_S = 5.0


def add_tune_options(gain: argparse.ArgumentParser) -> None:
    """Options of `tune`."""
    begin_verb(gain, "  kite-ground tune\n  kite-ground tune --step +10%\n"
               "  kite-ground tune --delay 0.2\n  kite-ground tune --identify\n\n"
               "In TRACK, a new value is flown and compared with the flight before. It stays only if you\n"
               "confirm it (with --yes: if the cross-track error did not grow). Otherwise, and after Ctrl-C,\n"
               "a lost link or any error, the old value is restored.")
    gain.add_argument("--delay", type=positive, metavar="S", help="dead time tau of links and actuator together, "
                      "without sampling, in seconds (default: as measured)")
    gain.add_argument("--seconds", type=positive, metavar="S", default=DELAY_MEASURE_S,
                      help=f"measure the delay for this many seconds (default {DELAY_MEASURE_S:g})")
    gain.add_argument("--step", type=_step, metavar="P%", help=f"change {GAIN_NAME} by this percentage, such as +10%% "
                      "or -5%%, in TRACK, and compare the flight before and after")
    gain._negative_number_matcher = re.compile(r"^-[\d.]+ ?%?$")  # otherwise -5% counts as an option
    gain.add_argument("--duration", type=positive, metavar="S", help="measure before and after a change for this many "
                      "seconds (default: two rounds of the eight)")
    gain.add_argument("--identify", action="store_true", help="identify K, gravity and the delay, with uncertainty, "
                      "while the kite flies eights, and propose settings for the prediction and gains")
    gain.add_argument("--loop-hz", type=positive, metavar="N", help=f"loop rate (default: the kite's {RATE_NAME})")
    gain.add_argument(_SPEED_OPTION, type=positive, metavar="X",
                      help="speed across the sky over line length [1/s], for the whole loop's limits (default: as the "
                      "kite flies now)")
    gain.add_argument("--yes", action="store_true", help="do not ask; undo what makes the flight worse")
    gain.add_argument("--json", action="store_true", help="print JSON for a script; sets nothing without --yes")
    add_snapshot_option(gain)


def tune(args: argparse.Namespace, connect: Connect) -> int:
    """kite-ground tune."""
    with connect() as session:
        session.check_contract()
        history = StateHistory()
        session.connection.add_observer(history.observe)
        if args.identify:
            _snapshot(args, session, lambda snapshots: snapshots.finish())
            return identify_and_set(args, session, history)
        flight = TuningFlight(session, history)
        report = None if args.delay else _measure(args, session, flight)
        advice, found = _advise(args, session, flight, report)
        new = _wanted(args, session, advice, found)
        result, written = None, False
        if new is not None:
            _snapshot(args, session, lambda snapshots: snapshots.protect(GAIN_NAME))
            with Trial(session, tell) as trial:
                if args.step or (found.law.eight and not found.urgent):
                    result = flight.step(trial, GAIN_NAME, new, advice.loop_delay_s, args.duration, _teller(args))
                    written = _keep(args, session, result)
                else:
                    trial.set(GAIN_NAME, new)
                    written = True
                if written:
                    trial.keep()
            _snapshot(args, session, lambda snapshots: snapshots.finish())
    if args.json:
        print(json.dumps({**gain_advice.as_dictionary(advice), **_decision(found), "measured": report and
                          delay_as_dictionary(report), "step": result and _step_as_dictionary(result),
                          "written": written}, indent=2))
    else:
        print(f"{GAIN_NAME} = {format_value(new)} 1/s, acknowledged by the kite" if written and new is not None
              else f"{GAIN_NAME} stays as it is")
    return 0


def _measure(args: argparse.Namespace, session: Session, flight: TuningFlight) -> DelayReport:
    """Measure the loop delay in flight. Raises UsageError if it is not found, and PRED_DELAY is not set either."""
    _teller(args)(f"measuring the delay for {args.seconds:g} s of flight")
    report = flight.measure_delay(args.seconds)
    if not args.json:
        print("\n".join(delay_lines(report)) + "\n", flush=True)
    if report.loop.whole_s is None and not session.parameters.fetch("PRED_DELAY"):
        raise UsageError(f"no loop delay found in {report.loop.states} states in "
                         f"{session.state.mode_name}: steering explains only {report.loop.fit:.0%} of the turning; "
                         "fly TRACK for longer (--seconds 40), or give --delay S")
    return report


def _advise(args: argparse.Namespace, session: Session, flight: TuningFlight,
            report: DelayReport | None) -> tuple[GainAdvice, FlownAdvice]:
    loop_hz = args.loop_hz or session.parameters.fetch(RATE_NAME)
    law = read_law(session)
    measured_s = report and report.loop.whole_s
    if report and measured_s is None:
        _teller(args)(f"this flight does not show the delay: assuming PRED_DELAY = {law.predicted_s:.4g} s")
        measured_s = law.predicted_s
    delay_s = args.delay or max(measured_s or 0.0, _LEAST_DELAY_S)
    advice = gain_advice.advise(delay_s, loop_hz, session.parameters.fetch(GAIN_NAME))
    session.connection.wait_until(lambda: session.state.position is not None, _POSITION_WAIT_S)
    speed = args.speed_over_length or gain_advice.speed_over_length(session.state)
    outer_l = session.parameters.fetch(OUTER_NAME)
    if speed and not law.predicted_s:
        advice = gain_advice.with_outer_loop(advice, speed, outer_l)
    flown = None
    if law.eight:
        seconds = args.seconds if report else _GLANCE_S
        flown = flight.effect(seconds) if report else flight.look(seconds)
    found = advise_on(law, advice, speed, outer_l, flown)
    if not args.json:
        lines = describe_flown(found, advice)
        if not law.predicted_s:
            lines += ["", *gain_advice.describe(advice), scale_line(advice)]
        lines += ["", f"present {GAIN_NAME} = {advice.present:.4g}: {_verdict(found, advice)}"]
        print("\n".join(lines), flush=True)
        if not speed:
            tell(f"limits of the whole loop not computed: the kite is not flying; give its speed with {_SPEED_OPTION} "
                 "X")
    return advice, found


def _wanted(args: argparse.Namespace, session: Session, advice: GainAdvice, found: FlownAdvice) -> float | None:
    """The gain to try, if there is a safe one and the user agrees."""
    if args.step:
        new = advice.present * args.step
        if found.law.scheduled:
            raise UsageError(f"not set: {found.reason}")
        limit = min(found.limit, found.wrong_limit or math.inf)
        if new >= limit and new > advice.present:
            raise UsageError(f"not set: {GAIN_NAME} = {new:.4g} would be unstable: the limit is {limit:.4g}")
        question = f"set {GAIN_NAME} from {advice.present:.4g} to {new:.4g}?"
    elif found.proposal is None:
        _teller(args)(f"nothing better to propose: {found.reason}")
        return None
    else:
        new = found.proposal
        question = f"set {GAIN_NAME} to {new:.4g}: {found.reason}?"
    if args.json and not args.yes:
        return None
    if not args.step and not found.law.predicted_s and new == advice.proposal:
        gain_advice.check_proposal(advice)
    return new if args.yes or confirm(session, question) else None


def _keep(args: argparse.Namespace, session: Session, result: StepResult) -> bool:
    """Show the effect; return whether the new value stays."""
    if not args.json:
        print("\n".join(effect_lines(result)), flush=True)
    if result.diverged:
        return False
    if args.yes:
        return result.after.cross_track_rad <= result.before.cross_track_rad
    return confirm(session, f"keep {result.name} = {result.new:.4g}?")


def _verdict(found: FlownAdvice, advice: GainAdvice) -> str:
    """The paper's verdict for the plain law off the eight, else that for the law in use."""
    law = found.law
    plain = not (law.eight or law.feed_forward or law.predicted_s)
    return gain_advice.verdict(advice, advice.present) if plain else found.verdict


def _decision(found: FlownAdvice) -> dict[str, object]:
    """Entries that replace the paper's decision, for scripts."""
    law = found.law
    if not (law.eight or law.feed_forward or law.predicted_s):
        return {"proposal": found.proposal, "flown": flown_as_dictionary(found)}
    return {"proposal": found.proposal, "verdict": found.verdict, "stable": not found.verdict.startswith("UNSTABLE"),
            "flown": flown_as_dictionary(found)}


def _teller(args: argparse.Namespace) -> Callable[[str], None]:
    return (lambda text: None) if args.json else tell


def _snapshot(args: argparse.Namespace, session: Session, action: Callable[[SnapshotStore], object]) -> None:
    """Run `action` on the snapshot; only warn if it cannot be kept."""
    try:
        action(snapshot_store(args, session))
    except GroundError as error:
        session.notice(f"warning: no snapshot: {error}")


def _step_as_dictionary(result: StepResult) -> dict[str, object]:
    return {**result._asdict(), "before": result.before._asdict(), "after": result.after._asdict()}


def _step(text: str) -> float:
    try:
        return parse_step(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
