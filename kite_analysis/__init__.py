"""Pure numerics shared by the bridge and the ground station: delay theory, metrics, reading of logs, plots."""
