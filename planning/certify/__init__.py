"""Certification: the proof that a timed trajectory keeps its limits and distances at every instant.

The proof shares no code with the planning stages that made the trajectory: its polynomial bounds,
motion bounds and distance queries are its own. (The native proof shares the definitions of shape,
pose and distance with the collision checker: ADR 8.)
"""
