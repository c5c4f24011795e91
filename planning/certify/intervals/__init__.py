"""Interval bounds: Bernstein polynomials, Taylor series, and branch and bound over trajectories."""
