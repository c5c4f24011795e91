"""Paths, piecewise polynomial curves and sampled trajectories."""
