"""Curves of the trajectory optimization: splines, charts, samples, path velocity."""
