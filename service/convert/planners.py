"""Planners to the wire."""
