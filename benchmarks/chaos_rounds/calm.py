"""Calm: servers to which nothing is done any more are ready, and have as much open as at first."""

import threading
import time

from benchmarks.chaos_rounds.caller import Caller
from benchmarks.chaos_rounds.fleet import Fleet
from benchmarks.chaos_rounds.journal import Journal
from benchmarks.chaos_rounds.keeper import Keeper

# What a server may have open besides what it has when it is new: connections of its database.
_POOL = 16
_SETTLE_WITHIN = 20.0


def all_ready(fleet: Fleet, journal: Journal) -> None:
    """Wait until every server is ready."""
    for keeper in fleet.keepers:
        caller = Caller(keeper, journal)
        try:
            caller.get("/readyz")
        finally:
            caller.close()


def settled(keeper: Keeper) -> dict[str, int]:
    """Return what a new server has open once all its workers are there."""
    before, now = {}, keeper.open_files()
    while now != before:
        threading.Event().wait(1.0)
        before, now = now, keeper.open_files()
    return now


def check_open_files(keeper: Keeper, journal: Journal, new: dict[str, int]) -> None:
    """Blame a server that has more open than a new one, once what it did has been put away."""
    until = time.monotonic() + _SETTLE_WITHIN
    allowed = {"pipe": 0, "anon_inode": 0, "socket": _POOL}
    while True:
        now = keeper.open_files()
        more = {
            kind: now[kind] - new[kind] for kind in now if now[kind] - new[kind] > allowed[kind]
        }
        if not more:
            return
        if time.monotonic() > until:
            what = f"has {more} more open than when it was new"
            journal.blame("nothing is left behind", "server", what)
            return
        threading.Event().wait(0.2)
