"""Shifts: what each client does in a round, at the same time as the others."""

import threading
from collections.abc import Callable
from functools import partial

from benchmarks.chaos_rounds.caller import Caller, GaveUp
from benchmarks.chaos_rounds.clients import Client
from benchmarks.chaos_rounds.fleet import Fleet
from benchmarks.chaos_rounds.journal import Journal

_PLANNERS, _ROBOTS = 2, 2


def work(fleet: Fleet, journal: Journal, *, seed: str, num_jobs: int, ids: dict[str, str]) -> None:
    """Let clients work until all that they asked for has ended.

    Args:
        fleet: The servers.
        journal: Of what clients ask.
        seed: Of all that is decided by chance.
        num_jobs: About as many are asked for.
        ids: Of the scenes that all plan in, by name.
    """
    num_plans = max(1, num_jobs // (2 * _PLANNERS))
    # A motion is a plan and an execution.
    num_motions = max(1, num_jobs // (4 * _ROBOTS))
    shifts: list[Callable[[Client], None]] = [
        *[partial(_plan_on, ids=ids, count=num_plans)] * _PLANNERS,
        *[partial(_move_on, count=num_motions)] * _ROBOTS,
    ]
    clients = [
        threading.Thread(target=_client, args=(fleet, journal, f"{seed} client {i}", shift))
        for i, shift in enumerate(shifts)
    ]
    for thread in clients:
        thread.start()
    for thread in clients:
        thread.join()


def _client(fleet: Fleet, journal: Journal, name: str, shift: Callable[[Client], None]) -> None:
    """Do what a client does, and put its own faults into the journal."""
    caller = Caller(fleet, journal)
    try:
        shift(Client(name, caller, journal, lambda: fleet.losses))
    except GaveUp:
        pass  # it is in the journal
    except Exception as fault:
        journal.blame("a client can work", name, repr(fault))
        raise
    finally:
        caller.close()


def _plan_on(client: Client, ids: dict[str, str], count: int) -> None:
    for _ in range(count):
        client.plan(ids)


def _move_on(client: Client, count: int) -> None:
    scene = client.scene()
    for i in range(count):
        client.move(scene, 1 + i)
