"""Profiles and transitions under jerk limits, by ruckig and our own optimiser."""
