"""Replays of motions as HTML pages that need no server."""
