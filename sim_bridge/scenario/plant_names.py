"""The plants that a scenario may name, the simplest first."""

PLANTS = TURNING_RATE, ONE_POINT, FOUR_POINT, VORTEX_LATTICE = (
    "turning-rate", "one-point", "four-point", "vortex-lattice")
