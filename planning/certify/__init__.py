"""The proof that a timed trajectory keeps its limits and its distances, between samples too.

It shares no code with what made the trajectory: polynomial bounds, motion bounds and distance
queries are its own. (The native proof shares what a shape, a pose and a distance are: ADR 8.)
"""
