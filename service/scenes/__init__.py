"""Scenes as records."""
