"""Roadmaps for many queries: built once, then queried."""
