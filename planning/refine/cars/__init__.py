"""Quicker arcs and lines for a car, each of which it can drive as it is."""
