"""kite-ground tune: the delay in the loop, what gains it allows, and what a step of one does to the flight."""

import argparse
import json
import math
import re
from collections.abc import Callable

from ground import tuning
from ground.cli_identify import identify_and_set
from ground.cli_options import Connect, add_command, add_snapshot_option, positive
from ground.errors import GroundError, UsageError, VehicleError
from ground.parameter_file import format_value
from ground.session import Session
from ground.snapshot import SnapshotKeeper
from ground.state_history import StateHistory
from ground.terminal import confirm, tell
from ground.tuning import GAIN_NAME, OUTER_NAME, RATE_NAME, GainAdvice
from ground.tuning_flight import DELAY_MEASURE_S, DelayReport, Effect, StepResult, TuningFlight, parse_step
from ground.tuning_report import delay_as_dictionary, delay_lines, effect_lines, scale_line

_SPEED_OPTION = "--speed-over-length"
_POSITION_WAIT_S = 2.0  # for telemetry that comes once a second or so
_LEAST_DELAY_S = 1e-3  # less than this is none: every gain would do


def add_tune_command(commands) -> None:
    """Add `tune`."""
    gain = add_command(commands, "tune", tune, f"measure the delay in the loop in flight, work out {GAIN_NAME} for it, "
                       "and set it or try a step", "  kite-ground tune\n  kite-ground tune --step +10%\n"
                       "  kite-ground tune --delay 0.2\n  kite-ground tune --identify")
    gain.add_argument("--delay", type=positive, metavar="S", help="dead time tau of links and actuator together, "
                      "without sampling, in seconds (default: as measured)")
    gain.add_argument("--seconds", type=positive, metavar="S", default=DELAY_MEASURE_S,
                      help=f"measure the delay for so long (default {DELAY_MEASURE_S:g})")
    gain.add_argument("--step", type=_step, metavar="P%", help=f"change {GAIN_NAME} by so many percent, such as +10%% "
                      "or -5%%, in TRACK, and compare the flight before and after")
    gain._negative_number_matcher = re.compile(r"^-[\d.]+ ?%?$")  # or -5% is taken for an option
    gain.add_argument("--duration", type=positive, metavar="S", help="with --step: measure before and after for so "
                      "long (default: two rounds of the eight)")
    gain.add_argument("--identify", action="store_true", help="find K, gravity and the delay with their uncertainty "
                      "from eights that are flown, and propose the predictor's settings with gains that suit them")
    gain.add_argument("--loop-hz", type=positive, metavar="N", help=f"loop rate (default: the vehicle's {RATE_NAME})")
    gain.add_argument(_SPEED_OPTION, type=positive, metavar="X",
                      help="speed across the sky over line length [1/s], for the whole loop's limits (default: as the "
                      "vehicle flies now)")
    gain.add_argument("--yes", action="store_true", help="do not ask before setting it; a step that is worse goes back")
    gain.add_argument("--json", action="store_true", help="for a script; sets nothing without --yes")
    add_snapshot_option(gain)


def tune(args: argparse.Namespace, connect: Connect) -> int:
    """tune."""
    with connect() as session:
        session.check_contract()
        history = StateHistory()
        session.connection.add_observer(history.observe)
        if args.identify:
            _snapshot(args, session, lambda keeper: keeper.finish())
            return identify_and_set(args, session, history)
        flight = TuningFlight(session, history)
        report = None if args.delay else _measure(args, session, flight)
        advice = _advise(args, session, report)
        result, written = None, False
        if args.step:
            result = _step_gain(args, session, flight, advice)
            written = result is not None and not result.diverged and _keep(args, session, result)
        else:
            written = _write_gain(args, session, advice)
        if written or result:
            _snapshot(args, session, lambda keeper: keeper.finish())
    if args.json:
        print(json.dumps({**tuning.as_dictionary(advice), "measured": report and delay_as_dictionary(report),
                          "step": result and _step_as_dictionary(result), "written": written}, indent=2))
    elif not args.step:
        print(f"{GAIN_NAME} = {format_value(advice.proposal)} 1/s, acknowledged by the vehicle" if written
              else f"{GAIN_NAME} stays as it is")
    return 0


def _measure(args: argparse.Namespace, session: Session, flight: TuningFlight) -> DelayReport:
    """The delay in the loop from the flight itself. Raises UsageError where that does not tell it."""
    if not args.json:
        tell(f"measuring the delay for {args.seconds:g} s of flight")
    report = flight.measure_delay(args.seconds)
    if not args.json:
        print("\n".join(delay_lines(report)) + "\n", flush=True)
    if report.loop.whole_s is None:
        raise UsageError(f"the delay in the loop cannot be told from {report.loop.states} states in "
                         f"{session.state.mode_name}: steering explains {report.loop.fit:.0%} of the turning; "
                         "fly TRACK for longer (--seconds 40), or give --delay S")
    return report


def _advise(args: argparse.Namespace, session: Session, report: DelayReport | None) -> GainAdvice:
    delay_s = args.delay or max((report and report.loop.whole_s) or 0.0, _LEAST_DELAY_S)
    loop_hz = args.loop_hz or session.parameters.fetch(RATE_NAME)
    advice = tuning.advise(delay_s, loop_hz, session.parameters.fetch(GAIN_NAME))
    session.connection.wait_until(lambda: session.state.position is not None, _POSITION_WAIT_S)
    speed = args.speed_over_length or tuning.speed_over_length(session.state)
    if speed:
        advice = tuning.with_outer_loop(advice, speed, session.parameters.fetch(OUTER_NAME))
    if not args.json:
        print("\n".join([*tuning.describe(advice), scale_line(advice)]), flush=True)
        if not speed:
            tell(f"the whole loop is left out: the vehicle does not fly; {_SPEED_OPTION} X would give its speed")
    return advice


def _step_gain(args: argparse.Namespace, session: Session, flight: TuningFlight,
               advice: GainAdvice) -> StepResult | None:
    """Try the step, if it is safe and the user agrees, and show what it did."""
    new = advice.present * args.step
    limit = min(advice.sampled_limit, advice.whole.limit if advice.whole else math.inf)
    if new >= limit and new > advice.present:
        raise UsageError(f"not set: {GAIN_NAME} = {new:.4g} would be unstable: the limit is {limit:.4g}")
    if args.json and not args.yes:
        return None
    if not args.yes and not confirm(session, f"set {GAIN_NAME} from {advice.present:.4g} to {new:.4g}?"):
        print(f"{GAIN_NAME} stays as it is")
        return None
    _snapshot(args, session, lambda keeper: keeper.protect(GAIN_NAME))
    result = flight.step(GAIN_NAME, new, advice.loop_delay_s, args.duration, tell)
    if not args.json:
        print("\n".join(effect_lines(result)), flush=True)
    return result


def _keep(args: argparse.Namespace, session: Session, result: StepResult) -> bool:
    """Whether the new value stays; goes back to the old one where it does not."""
    worse = _sum(result.after) > _sum(result.before)
    back = worse if args.yes else confirm(session, f"go back to {GAIN_NAME} = {result.old:.4g}?")
    if back:
        session.parameters.set(GAIN_NAME, result.old)
    if not args.json:
        value = result.old if back else result.new
        print(f"{GAIN_NAME} = {format_value(value)} 1/s, acknowledged by the vehicle" + (": back" if back else ""))
    return not back


def _sum(effect: Effect) -> float:
    """One number to compare flights by: the square sum of both errors [rad^2]."""
    return effect.cross_track_rad**2 + effect.turning_rad**2


def _write_gain(args: argparse.Namespace, session: Session, advice: GainAdvice) -> bool:
    """Whether the proposal was written: it differs, it is safe, and the user agrees."""
    if advice.proposal == advice.present or (args.json and not args.yes):
        return False
    tuning.check_proposal(advice)
    if not args.yes and not confirm(session, f"set {GAIN_NAME} to {advice.proposal:.4g}, which is 1 / (e tau)?"):
        return False
    _snapshot(args, session, lambda keeper: keeper.protect(GAIN_NAME))
    if session.parameters.set(GAIN_NAME, advice.proposal) != advice.proposal:
        raise VehicleError(f"{GAIN_NAME}: another value was acknowledged")
    return True


def _snapshot(args: argparse.Namespace, session: Session, action: Callable[[SnapshotKeeper], object]) -> None:
    """Do something about the snapshot; where it cannot be kept, that is said, and no more."""
    try:
        action(SnapshotKeeper(session, args.snapshot, args.wall_clock))
    except GroundError as error:
        session.notice(f"warning: no snapshot: {error}")


def _step_as_dictionary(result: StepResult) -> dict[str, object]:
    return {**result._asdict(), "before": result.before._asdict(), "after": result.after._asdict()}


def _step(text: str) -> float:
    try:
        return parse_step(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
