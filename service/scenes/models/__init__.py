"""Scenes in JSON: what they hold, and how they are edited."""
