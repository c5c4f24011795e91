"""Constraints of the trajectory optimisation: distances, rates, loads, path constraints."""
