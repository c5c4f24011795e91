"""Checks of what callers add, by samples."""
