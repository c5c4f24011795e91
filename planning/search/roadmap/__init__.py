"""Roadmaps for many queries: built once, then asked."""
