"""The scenario's section `kite`: the kites that have forces. Defaults are the kite of the reference, area 10.18 m^2."""

from sim_bridge.key import Key

KITE_KEYS: dict[str, Key] = {}
