"""The proof that a timed trajectory keeps its limits and its distances, between samples too.

It shares no code with what made the trajectory: polynomial bounds, motion bounds and distance
queries are its own.
"""
