"""A kite whose wing is a vortex lattice: potential flow, as in the simulations of J. H. Baayen (2012)."""
