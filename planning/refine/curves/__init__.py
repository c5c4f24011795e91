"""Curves and their derivatives: splines, charts, path velocity."""
