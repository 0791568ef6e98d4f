"""What observers of a flight see of a tick."""

from typing import NamedTuple

from sim_bridge.equipment.sensors import Sample
from sim_bridge.flight.truth_columns import TruthRow
from sim_bridge.runtimes.tick_output import TickOutput


class TickRecord(NamedTuple):
    """Record of a tick, for observers of a flight."""

    tick: int
    time_s: float
    samples: list[Sample]
    datagrams: list[bytes]
    output: TickOutput
    heard: list[bytes]  # frames that reached the ground stations
    row: TruthRow | None  # of the truth, if this tick has one
