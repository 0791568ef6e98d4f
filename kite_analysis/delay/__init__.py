"""Delay in the loop: limits of the gains, their best values, the roots of the characteristic equation."""
