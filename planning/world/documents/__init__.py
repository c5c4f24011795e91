"""Scenes as documents: read, checked, edited and written."""
