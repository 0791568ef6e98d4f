"""kite-ground tune --identify: constants of the kite in flight, settings for the prediction, and their effect."""

import argparse
import json
import math

from ground.cli.terminal import confirm, tell
from ground.errors import UsageError
from ground.session import Session
from ground.tuning import gain_advice
from ground.tuning.gain_advice import RATE_NAME
from ground.tuning.identification import Identified, identify_in_flight, propose
from ground.tuning.in_flight import Effect, TuningFlight
from ground.tuning.trial import Trial
from ground.vehicle.history import StateHistory

LEAST_SECONDS = 40.0
_SETTLE_S = 10.0


def identify_and_set(args: argparse.Namespace, session: Session, history: StateHistory) -> int:
    """kite-ground tune --identify; `history` observes the session's connection."""
    seconds = max(args.seconds, LEAST_SECONDS)
    loop_hz = args.loop_hz or session.parameters.fetch(RATE_NAME)
    flight = TuningFlight(session, history)
    if not args.json:
        tell(f"watching {seconds:.0f} s of flight")
    found = identify_in_flight(session, history, seconds, loop_hz)
    before = flight.effect(seconds)
    speed = args.speed_over_length or gain_advice.speed_over_length(session.state)
    if not speed:
        raise UsageError("the kite does not report its speed: give --speed-over-length X, in 1/s")
    proposed = propose(found, speed, loop_hz, session.parameters.table)
    old = {name: session.parameters.fetch(name) for name in proposed}
    if not args.json:
        print("\n".join([*_found_lines(found), "", *_proposal_lines(proposed, old)]), flush=True)
    after, kept = None, False
    if args.yes or (not args.json and confirm(session, "set these and fly with them?")):
        with Trial(session, tell) as trial:
            for name, value in proposed.items():  # the prediction before the gains that need it
                trial.set(name, value)
            if not args.json:
                tell(f"acknowledged; {_SETTLE_S:.0f} s to settle, then {seconds:.0f} s to measure")
            after, diverged = flight.try_out(trial, before, _SETTLE_S, seconds)
            kept = _keep(args, session, before, after, diverged)
            if kept:
                trial.keep()
    if args.json:
        print(json.dumps({**_as_dictionary(found), "proposed": proposed, "present": old,
                          "before": before._asdict(), "after": after and after._asdict(), "written": kept}, indent=2))
    elif after is not None:
        print("kept, acknowledged by the kite" if kept else "old values restored, acknowledged by the kite")
    return 0


def _found_lines(found: Identified) -> list[str]:
    law, actuator = found.law, found.actuator
    lines = [
        f"turning-rate law on the {law.angle}, R2 {law.r2:.4f}",
        f"  K                {law.k_rad_per_m:9.4f} +- {law.k_rad_per_m_std:.2g} rad/m",
        f"  gravity          {law.gravity_m_s2:9.4f} +- {law.gravity_m_s2_std:.2g} m/s2",
        f"  offset           {law.offset_rad_s:9.4f} +- {law.offset_rad_s_std:.2g} rad/s",
        f"delay in the loop  {found.delay_s:9.4f} +- {found.delay_s_std:.2g} s",
        f"  sample age       {found.sample_age_s:9.4f} s" if found.sample_age_s is not None else
        "  sample age               -     sensor and firmware clocks differ",
        f"  from a sample to the actuator's response {actuator.dead_time_s:.4f} s, R2 {actuator.actuator_r2:.4f}",
    ]
    if actuator.rate_limit_per_s:
        lines.append(f"actuator rate      {actuator.rate_limit_per_s:9.4f} per second")
    return lines


def _proposal_lines(proposed: dict[str, float], old: dict[str, float]) -> list[str]:
    return [f"{'':<14}{'present':>10}{'proposed':>10}",
            *(f"{name:<14}{old[name]:>10.4g}{value:>10.4g}" for name, value in proposed.items())]


def _keep(args: argparse.Namespace, session: Session, before: Effect, after: Effect, diverged: bool) -> bool:
    """Show the effect; return whether the new values stay."""
    if not args.json:
        for name, was, now in (("cross-track error, RMS", before.cross_track_rad, after.cross_track_rad),
                               ("turning-angle error, RMS", before.turning_rad, after.turning_rad)):
            print(f"{name:<26}{math.degrees(was):>6.2f} deg before{math.degrees(now):>8.2f} deg after", flush=True)
    if diverged:
        tell("the flight diverged")
        return False
    return after.cross_track_rad <= before.cross_track_rad if args.yes else confirm(session, "keep these?")


def _as_dictionary(found: Identified) -> dict[str, object]:
    return {"law": found.law._asdict(), "actuator": found.actuator._asdict(), "sample_age_s": found.sample_age_s,
            "delay_s": found.delay_s, "delay_s_std": found.delay_s_std}
