"""Roadmaps, kept in this process and beside the server's records."""

from functools import cache
from pathlib import Path

from planning import RoadmapCache


@cache
def shelf_in(folder: str) -> RoadmapCache:
    """Return this process's shelf over a folder that all processes of a server share."""
    return RoadmapCache(folder=Path(folder))
