"""Roadmaps, kept in this process and beside the server's records."""

from functools import cache
from pathlib import Path

from planning import RoadmapShelf


@cache
def shelf_in(folder: str) -> RoadmapShelf:
    """Return this process's shelf over a folder that all processes of a server share."""
    return RoadmapShelf(folder=Path(folder))
