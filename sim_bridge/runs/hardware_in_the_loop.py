"""Hardware in the loop: a real board flies the simulated kite, through a cable or a radio."""

from collections.abc import Callable
from typing import Any

from sim_bridge.equipment.sensors import SAMPLE_BYTES
from sim_bridge.flight.flight import Flight
from sim_bridge.links.port import open_port
from sim_bridge.links.wire import STEERING_BYTES
from sim_bridge.runs.run import RunOptions, RunResult, run_scenario
from sim_bridge.runtimes.real_time import HilRuntime
from sim_bridge.scenario.scenario import Scenario

_STATE_BYTES = 83  # a KITE_STATE frame
_OTHER_BYTES_S = 400.0  # heartbeat, status, position, texts, answers
_FULL = 0.9  # a link that is fuller than this makes frames wait


def fly_board(scenario: Scenario, link: str, options: RunOptions, notice: Callable[[str], None]
              ) -> tuple[RunResult, dict[str, Any]]:
    """Fly `scenario` with the board at `link`; return the result, and what was measured of the board.

    Raises:
        ScenarioError: the link cannot be opened.
        FirmwareError: the board is silent, or would not fly.
    """
    port = open_port(link, notice)
    for warning in link_warnings(scenario, port.bytes_per_s):
        notice(warning)
    runtime = HilRuntime(port)
    result = run_scenario(scenario, options, runtime=runtime, notice=notice)
    measured = board_report(result.flight, runtime.delay())
    measured |= {"bytes_in": runtime.bytes_in, "bytes_out": runtime.bytes_out}
    if problem := delay_problem(measured):
        notice(problem)
    return result, measured


def board_report(flight: Flight, own: tuple[float, float] | None) -> dict[str, Any]:
    """Delays of the control path [s]: the board's own (median, and how much more it can be), asked, emulated, flown.

    None if unknown, such as the board's own delay if it does not send KITE_STATE.
    """
    board_s, jitter_s = own or (None, None)
    emulated_s = flight.delay_emulated_s
    return {
        "board_delay_s": board_s, "board_jitter_s": jitter_s, "delay_asked_s": flight.delay_asked_s,
        "delay_emulated_s": emulated_s, "delay_flown_s": None if board_s is None else emulated_s + board_s,
    }


def delay_problem(measured: dict[str, Any]) -> str | None:
    """Why the delay flown is not the requested one, in a line; None if it is."""
    asked_s, board_s = measured["delay_asked_s"], measured["board_delay_s"]
    asked_ms = 1000 * asked_s
    if board_s is None:
        return (f"the board's delay is unknown (it comes from KITE_STATE: see STATE_HZ), so the {asked_ms:.0f} "
                "ms requested were emulated on top of it")
    if board_s > asked_s:
        return (f"the board alone takes {1000 * board_s:.0f} ms, more than the {asked_ms:.0f} ms requested: "
                f"{1000 * measured['delay_flown_s']:.0f} ms were flown")
    return None


def link_warnings(scenario: Scenario, bytes_per_s: float) -> list[str]:
    """Warnings if traffic exceeds a link of `bytes_per_s` each way (0: unknown), with a remedy."""
    if not bytes_per_s:
        return []
    loop_hz = scenario.parameter("LOOP_HZ")
    state_hz = min(loop_hz, scenario.parameter("STATE_HZ"))
    to_board = SAMPLE_BYTES * (scenario.sensors.rate_hz or loop_hz)
    from_board = STEERING_BYTES * loop_hz + _STATE_BYTES * state_hz + _OTHER_BYTES_S
    warnings = []
    if to_board > _FULL * bytes_per_s:
        warnings.append(f"{to_board:.0f} bytes/s of samples exceed the link's {bytes_per_s:.0f}: "
                        "lower sensors.rate_hz, or use a faster link")
    if from_board > _FULL * bytes_per_s:
        room = (_FULL * bytes_per_s - STEERING_BYTES * loop_hz - _OTHER_BYTES_S) / _STATE_BYTES
        help_ = f"set --param STATE_HZ={max(1, int(room))}" if room > 1 else "use a faster link"
        warnings.append(f"{from_board:.0f} bytes/s from the board exceed the link's {bytes_per_s:.0f}: {help_}")
    return warnings
