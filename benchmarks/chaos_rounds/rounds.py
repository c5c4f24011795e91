"""Rounds: clients work while faults happen; then, in calm, everything is looked at."""

import random
import shutil
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from benchmarks.chaos_rounds.caller import Caller, GaveUp
from benchmarks.chaos_rounds.checker import check
from benchmarks.chaos_rounds.clients import Client
from benchmarks.chaos_rounds.databases import Database, Postgresql, Sqlite
from benchmarks.chaos_rounds.disk import SmallDisk
from benchmarks.chaos_rounds.faults import FaultKind, Havoc, draw
from benchmarks.chaos_rounds.journal import Journal, Violation
from benchmarks.chaos_rounds.keeper import Keeper
from benchmarks.chaos_rounds.mix import scenes
from benchmarks.chaos_rounds.records import check_files, check_rows
from benchmarks.chaos_rounds.survey import Survey

_MEGABYTES = 256
_PLANNERS, _ROBOTS = 2, 2
# Faults for each job.
_RATE = 0.4
# What a server may have open besides what it has when it is new: connections of its database.
_POOL = 16
_SETTLE_WITHIN = 20.0


@dataclass(frozen=True)
class Round:
    """What came of a round.

    Attributes:
        name: Of the database and the round.
        jobs: How many were accepted.
        faults: How often what was done.
        refused: How often a server could not start while something was wrong.
        outcomes: How many jobs ended how: `plan succeeded`, `plan worker_crashed`, and so on.
        answers: How many answers there were by status and code.
        violations: Of what must hold.
        seconds: It took [s].
    """

    name: str
    jobs: int
    faults: Counter[FaultKind]
    refused: int
    outcomes: Counter[str]
    answers: Counter[str]
    violations: list[Violation]
    seconds: float


class Site:
    """A database, a data folder and the jobs of all rounds on them.

    Attributes:
        database: Of the servers.
        data: Their data folder.
        log: What they printed.
    """

    def __init__(self, database: Database, data: Path, log: Path) -> None:
        """Begin without jobs."""
        self.database = database
        self.data = data
        self.log = log
        self._ends: dict[str, str] = {}
        self._rest: set[Path] = set()
        self._earlier: dict[str, list[str]] = {"plan": [], "execution": []}

    def round(self, number: int, num_jobs: int, seed: int) -> Round:
        """Do a round.

        Args:
            number: Of the round.
            num_jobs: How many jobs to ask for, about.
            seed: Of the faults, and of what is asked for.
        """
        began = time.monotonic()
        name = f"{self.database.name} {number}"
        journal = Journal()
        environment = {"WAYPROOF_PLAN_SLOTS": "2", **self.database.environment}
        keeper = Keeper(self.data, self.log, environment, journal)
        keeper.start()
        try:
            done, outcomes = self._in_server(keeper, journal, f"{seed} {name}", num_jobs)
        finally:
            if keeper.url:
                keeper.end()
            keeper.check_gone()
        journal.violations += check_rows(self.database, self._ends)
        kills = sum(done[kind] for kind in FaultKind if kind.endswith(("-9", "-11")))
        journal.violations += check_files(self.data, self._rest, kills)
        seconds = time.monotonic() - began
        answers, violations = journal.answers, journal.violations
        jobs = len(journal.asked)
        return Round(name, jobs, done, keeper.refused, outcomes, answers, violations, seconds)

    def _in_server(
        self, keeper: Keeper, journal: Journal, seed: str, num_jobs: int
    ) -> tuple[Counter[FaultKind], Counter[str]]:
        havoc, outcomes = Havoc(keeper, self.database), Counter[str]()
        caller = Caller(keeper, journal)
        try:
            ids = {
                name: caller.ask("POST", "/v1/scenes", document).json()["id"]
                for name, document in scenes().items()
            }
            new = _settled(keeper)
            work(keeper, journal, havoc, seed=seed, num_jobs=num_jobs, ids=ids)
            caller.get("/readyz")
            outcomes = self._look(caller, journal)
            _check_files_of_process(keeper, journal, new)
        except GaveUp:
            pass  # it is in the journal
        finally:
            caller.close()
        return havoc.done, outcomes

    def _look(self, caller: Caller, journal: Journal) -> Counter[str]:
        """Look at every job of the round, and note how it ended."""
        survey = Survey(caller, journal)
        seen = list(survey.seen(journal.asked))
        listed = {
            kind: [one for one in survey.listed(kind) if one not in earlier]
            for kind, earlier in self._earlier.items()
        }
        journal.violations += check(seen, listed)
        outcomes: Counter[str] = Counter()
        for one in seen:
            code = (one.job["failure"] or {"code": one.job["state"]})["code"]
            outcomes[f"{one.asked.kind} {code}"] += 1
            self._ends[one.asked.id] = one.job["state"]
        for identifier in survey.extra:
            self._ends[identifier] = caller.get(f"/v1/plans/{identifier}")["state"]
        self._earlier["plan"] += [*listed["plan"], *survey.extra]
        self._earlier["execution"] += listed["execution"]
        return outcomes


@contextmanager
def site(name: str) -> Iterator[Site]:
    """Have a database of a kind, on a small disk, and a data folder for a while.

    Args:
        name: Of the kind: "sqlite" or "postgresql".
    """
    with ExitStack() as stack:
        folder = Path(tempfile.mkdtemp(prefix="wp-chaos-"))
        stack.enter_context(_removed(folder))
        # PostgreSQL refuses to be root, and so runs as a user who has to get there.
        folder.chmod(0o711)
        disk = SmallDisk(folder / "disk", _MEGABYTES)
        stack.callback(disk.close)
        data = disk.folder / "data"
        if name == "sqlite":
            database: Database = Sqlite(data, disk)
        else:
            database = Postgresql(folder / "cluster", disk)
        stack.callback(database.close)
        yield Site(database, data, folder / "server.log")


def work(
    keeper: Keeper, journal: Journal, havoc: Havoc, *, seed: str, num_jobs: int, ids: dict[str, str]
) -> None:
    """Let clients work while faults happen, until all that was asked for has ended.

    Args:
        keeper: Of the server.
        journal: Of what clients ask.
        havoc: Does the faults.
        seed: Of all that is decided by chance.
        num_jobs: About as many are asked for.
        ids: Of the scenes that all plan in, by name.
    """
    faults = draw(random.Random(seed), max(1, round(_RATE * num_jobs)), havoc.database)
    num_plans = max(1, num_jobs // (2 * _PLANNERS))
    # A motion is a plan and an execution.
    num_motions = max(1, num_jobs // (4 * _ROBOTS))
    shifts: list[Callable[[Client], None]] = [
        *[partial(_plan_on, ids=ids, count=num_plans)] * _PLANNERS,
        *[partial(_move_on, count=num_motions)] * _ROBOTS,
    ]
    clients = [
        threading.Thread(target=_client, args=(keeper, journal, f"{seed} client {i}", shift))
        for i, shift in enumerate(shifts)
    ]
    troubles = threading.Thread(target=havoc.run, args=(faults,))
    for thread in (troubles, *clients):
        thread.start()
    for thread in clients:
        thread.join()
    havoc.stop()
    troubles.join()


def _client(keeper: Keeper, journal: Journal, name: str, shift: Callable[[Client], None]) -> None:
    """Do what a client does, and put its own faults into the journal."""
    caller = Caller(keeper, journal)
    try:
        shift(Client(name, caller, journal, lambda: keeper.losses))
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


def _settled(keeper: Keeper) -> dict[str, int]:
    """Return what a new server has open once all its workers are there."""
    before, now = {}, keeper.open_files()
    while now != before:
        threading.Event().wait(1.0)
        before, now = now, keeper.open_files()
    return now


def _check_files_of_process(keeper: Keeper, journal: Journal, new: dict[str, int]) -> None:
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


@contextmanager
def _removed(folder: Path) -> Iterator[None]:
    try:
        yield
    finally:
        shutil.rmtree(folder, ignore_errors=True)
