"""Curves of the trajectory optimisation: splines, charts, samples, path velocity."""
