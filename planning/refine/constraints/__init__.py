"""Constraints of the trajectory optimization: distances, rates, loads, path constraints."""
