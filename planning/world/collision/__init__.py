"""Collision checks, distance queries and margins of a loaded scene."""
