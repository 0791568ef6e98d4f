"""What a sweep asks of its workers. Importing this imports nothing that flies: see `fly_batch`."""

import time
from typing import Any

from sim_bridge.errors import FirmwareError, ScenarioError
from sim_bridge.native.choice import choose_loop
from sim_bridge.runs.fingerprint import code_fingerprint
from sim_bridge.sweeps.results import METRICS


def fly_batch(batch: list[tuple[int, dict[str, Any]]], code: str, interpreted: bool, seconds: float
              ) -> list[dict[str, Any]]:
    """Fly the runs of `batch` (number, scenario as a dictionary) for about `seconds` of wall time, one at least.

    Returns the rows of those flown but for the axes' values, in order. A worker imports what flies here, at its first
    batch, compiled or `interpreted` as the sweep's own process has it.

    Raises:
        ScenarioError: the code here is not that of the fingerprint `code`.
    """
    if code_fingerprint() != code:
        raise ScenarioError("the cluster's workers have different code: install the same version on all machines")
    choose_loop(interpreted)
    begin = time.monotonic()
    rows = []
    for run, content in batch:
        rows.append(_fly_run(run, content))
        if time.monotonic() - begin >= seconds:
            break
    return rows


def _fly_run(run: int, content: dict[str, Any]) -> dict[str, Any]:
    """One row. What cannot be flown is a result, too."""
    from sim_bridge.runs.run import RunOptions, run_scenario  # noqa: PLC0415  what flies
    from sim_bridge.scenario.scenario import Scenario  # noqa: PLC0415  with the settings of what flies

    scenario = Scenario.from_dict(content, f"run {run}")
    row: dict[str, Any] = {"run": run, "seed": scenario.run.seed, **dict.fromkeys(METRICS, "")}
    try:
        numbers = run_scenario(scenario, RunOptions(), notice=lambda _: None).numbers
    except (ScenarioError, FirmwareError) as error:
        return row | {"verdict": "refused", "trouble": str(error)}
    return row | {name: numbers[name] for name in METRICS if numbers.get(name) is not None}
