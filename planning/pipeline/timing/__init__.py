"""Timing of candidate motions: options, curves along a path, their durations."""
