"""What settings are where nothing else is said: by what this machine and its user have."""

import os
from pathlib import Path

GIB = 2**30


def default_data_dir() -> Path:
    """Return the user's state folder for this program (XDG base directories)."""
    state = os.environ.get("XDG_STATE_HOME", "")
    return (Path(state) if state else Path.home() / ".local" / "state") / "wayproof"


def default_plan_slots() -> int:
    """Return one less than there are processors, at least one, at most eight."""
    return min(8, max(1, (os.cpu_count() or 1) - 1))


def default_query_slots() -> int:
    """Return one for every two processors, at least one, at most four."""
    return min(4, max(1, (os.cpu_count() or 1) // 2))


def default_worker_memory() -> int:
    """Return half of this machine's memory, 1 to 8 GiB [bytes]."""
    machine = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return min(8 * GIB, max(GIB, machine // 2))
