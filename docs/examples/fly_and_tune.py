"""Connects to a kite, flies the eight, measures the delay in the loop, and keeps a gain only if it helps.

Start a simulated kite first, then this beside it:

    kite-sitl run small-kite --speed 1 --ground --forever
    python docs/examples/fly_and_tune.py
"""

import sys

import numpy as np

import ground


def fly_and_tune(kite: ground.Kite) -> None:
    """One tuning session: from arming to a gain that is kept only if the kite tracks better with it."""
    if not kite.armed:
        kite.arm()
    if kite.mode != "TRACK":
        kite.set_mode("TRACK")
    kite.wait_for(lambda state: abs(state.cross_track) < 0.2, timeout_s=60.0, what="cross-track error below 0.2 rad")

    report = kite.measure_delay(20.0)
    if report.round_trip:
        print(f"ground link: {1e3 * report.round_trip.median_s:.0f} ms round trip, "
              f"spread {1e3 * report.round_trip.spread_s:.0f} ms")
    if report.loop.whole_s is None:
        print(f"the steering explains only {report.loop.fit:.0%} of the turning: no delay found")
        return
    advice = kite.advise(report.loop.whole_s)
    print(f"loop delay {advice.delay_s:.3f} s: P = {advice.present:.3g}, "
          f"best {advice.sampled_optimum:.3g}, limit {advice.sampled_limit:.3g} 1/s")

    factor = 0.9 if advice.present > advice.sampled_optimum else 1.1
    result = kite.step_gain(factor, advice.delay_s)
    for when, effect in (("before", result.before), ("after", result.after)):
        print(f"{when:>6}: cross-track {np.degrees(effect.cross_track_rad):.2f} deg, "
              f"turning angle {np.degrees(effect.turning_rad):.1f} deg RMS")
    if result.after.turning_rad > result.before.turning_rad:
        kite.parameters.revert("INNER_P")
        print("worse: old gain restored")

    last = kite.history.record(seconds=30.0)
    print(f"steering over the last {np.ptp(last.time_s):.0f} s: "
          f"{np.sqrt(np.mean(last.set_steering ** 2)):.3f} RMS of {len(last.time_s)} states")


if __name__ == "__main__":
    try:
        with ground.connect(*sys.argv[1:]) as connected:
            fly_and_tune(connected)
    except ground.GroundError as error:
        sys.exit(f"fly_and_tune: {error}")
