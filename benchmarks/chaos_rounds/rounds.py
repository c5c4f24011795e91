"""Rounds: clients work while faults happen; then, in calm, everything is looked at."""

import random
import shutil
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from benchmarks.chaos_rounds.caller import Caller, GaveUp
from benchmarks.chaos_rounds.calm import all_ready, check_open_files, settled
from benchmarks.chaos_rounds.checker import check
from benchmarks.chaos_rounds.databases import Database, Postgresql, Sqlite
from benchmarks.chaos_rounds.disk import SmallDisk
from benchmarks.chaos_rounds.faults import Fault, FaultKind, Havoc, draw, kinds_of
from benchmarks.chaos_rounds.fleet import Fleet
from benchmarks.chaos_rounds.journal import Journal, Violation
from benchmarks.chaos_rounds.keeper import Keeper
from benchmarks.chaos_rounds.machines import Machines, OwnMachine, RayMachines
from benchmarks.chaos_rounds.mix import scenes
from benchmarks.chaos_rounds.records import check_files, check_rows
from benchmarks.chaos_rounds.shifts import work
from benchmarks.chaos_rounds.survey import Survey

_MEGABYTES = 256
# From the start of a server until it is ready, workers and all, on a machine that is not busy [s].
_USUAL_START = 4.0
# Faults for each job.
_RATE = 0.4


@dataclass(frozen=True)
class Round:
    """What came of a round.

    Attributes:
        name: Of the database, of the engine if that is not the usual one, and of the round.
        jobs: How many were accepted.
        faults: How often what was done.
        refused: How often a server could not start while something was wrong.
        stood_down: How often one ended because another one had taken the database over.
        outcomes: How many jobs ended how: `plan succeeded`, `plan worker_crashed`, and so on.
        answers: How many answers there were by status and code.
        violations: Of what must hold.
        seconds: It took [s].
    """

    name: str
    jobs: int
    faults: Counter[FaultKind]
    refused: int
    stood_down: int
    outcomes: Counter[str]
    answers: Counter[str]
    violations: list[Violation]
    seconds: float


class Site:
    """A database, a data folder and the jobs of all rounds on them.

    Attributes:
        database: Of the servers.
        data: The data folder of each.
        machines: Where their workers are.
    """

    def __init__(
        self, database: Database, data: Sequence[Path], logs: Path, machines: Machines
    ) -> None:
        """Begin without jobs; each server has a log of its own in the folder `logs`."""
        self.machines = machines
        self.database = database
        self.data = data
        self._logs = logs
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
        name = f"{self._name} {number}"
        journal = Journal()
        fleet = self._fleet(journal)
        fleet.start()
        try:
            done, outcomes = self._in_servers(fleet, journal, f"{seed} {name}", num_jobs, began)
        finally:
            fleet.end()
        journal.violations += check_rows(self.database, self._ends)
        kills = sum(done[kind] for kind in FaultKind if kind.endswith(("-9", "-11")))
        for folder in self.data:
            journal.violations += check_files(folder, self._rest, kills)
        return Round(
            name=name,
            jobs=len(journal.asked),
            faults=done,
            refused=fleet.refused,
            stood_down=fleet.stood_down,
            outcomes=outcomes,
            answers=journal.answers,
            violations=journal.violations,
            seconds=time.monotonic() - began,
        )

    def printed(self) -> bytes:
        """Return what the servers have printed, one after the other."""
        return b"".join(log.read_bytes() for log in sorted(self._logs.glob("server-*.log")))

    @property
    def _name(self) -> str:
        engine = "" if self.machines.name == "process" else f" {self.machines.name}"
        return f"{self.database.name}{engine}" + (f" x{n}" if (n := len(self.data)) > 1 else "")

    def _fleet(self, journal: Journal) -> Fleet:
        environment = {"WAYPROOF_PLAN_SLOTS": "2", **self.database.environment}
        environment |= self.machines.environment
        return Fleet([
            Keeper(
                folder,
                self._logs / f"server-{number}.log",
                environment,
                journal,
                self.machines,
                is_shared=len(self.data) > 1,
            )
            for number, folder in enumerate(self.data, 1)
        ])

    def _in_servers(
        self, fleet: Fleet, journal: Journal, seed: str, num_jobs: int, began: float
    ) -> tuple[Counter[FaultKind], Counter[str]]:
        havoc, outcomes = Havoc(fleet, self.database), Counter[str]()
        faults = self._faults(seed, num_jobs)
        caller = Caller(fleet, journal)
        try:
            with fleet.watched(havoc.is_troubled):
                all_ready(fleet, journal)
                # Where a start takes longer than from one fault to the next one, nothing gets done.
                slowness = (time.monotonic() - began) / (_USUAL_START * len(self.data))
                ids = {
                    name: caller.ask("POST", "/v1/scenes", document).json()["id"]
                    for name, document in scenes().items()
                }
                new = [settled(keeper) for keeper in fleet.keepers]
                with havoc.doing(faults, max(1.0, slowness)):
                    work(fleet, journal, seed=seed, num_jobs=num_jobs, ids=ids)
                all_ready(fleet, journal)
                outcomes = self._look(caller, journal)
                for keeper, before in zip(fleet.keepers, new, strict=True):
                    check_open_files(keeper, journal, before)
        except GaveUp:
            pass  # it is in the journal
        finally:
            caller.close()
        return havoc.done, outcomes

    def _faults(self, seed: str, num_jobs: int) -> list[Fault]:
        kinds = kinds_of(self.database.name, self.machines.name, len(self.data))
        return draw(random.Random(seed), max(1, round(_RATE * num_jobs)), kinds)

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
            outcomes[f"{one.asked.poison} {one.asked.kind} {code}".lstrip()] += 1
            self._ends[one.asked.id] = one.job["state"]
        for identifier in survey.extra:
            self._ends[identifier] = caller.get(f"/v1/plans/{identifier}")["state"]
        self._earlier["plan"] += [*listed["plan"], *survey.extra]
        self._earlier["execution"] += listed["execution"]
        return outcomes


@contextmanager
def site(name: str, engine: str = "process", num_servers: int = 1) -> Iterator[Site]:
    """Have a database of a kind, on a small disk, and data folders for a while.

    Args:
        name: Of the kind: "sqlite" or "postgresql".
        engine: Of the servers: "process" or "ray".
        num_servers: On the database; SQLite has one.
    """
    with ExitStack() as stack:
        folder = Path(tempfile.mkdtemp(prefix="wp-chaos-"))
        stack.enter_context(_removed(folder))
        # PostgreSQL refuses to be root, and so runs as a user who has to get there.
        folder.chmod(0o711)
        disk = SmallDisk(folder / "disk", _MEGABYTES)
        stack.callback(disk.close)
        data = [disk.folder / f"data-{number}" for number in range(1, num_servers + 1)]
        if name == "sqlite":
            database: Database = Sqlite(data[0], disk)
        else:
            database = Postgresql(folder / "cluster", disk)
        stack.callback(database.close)
        machines: Machines = RayMachines() if engine == "ray" else OwnMachine()
        stack.callback(machines.close)
        yield Site(database, data, folder, machines)


@contextmanager
def _removed(folder: Path) -> Iterator[None]:
    try:
        yield
    finally:
        shutil.rmtree(folder, ignore_errors=True)
