"""What a server leaves behind: rows without a job, files that are half written."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from benchmarks.chaos_rounds.databases import Database
from benchmarks.chaos_rounds.journal import Violation

_STATES = {"aborted": "failed"}
_PARTS = ("job_bodies", "job_summaries", "job_events", "job_makers")


def check_rows(database: Database, ends: Mapping[str, str]) -> list[Violation]:
    """Return what is wrong with the tables of a server that has ended.

    Args:
        database: Its.
        ends: The final state of every job that there should be, as the API showed it.
    """
    return [*_jobs(database, ends), *_parts(database), *_sound(database)]


def check_files(data: Path, known: set[Path], num_kills: int) -> list[Violation]:
    """Return the half-written files in a data folder that no server uses.

    Args:
        data: The data folder.
        known: Such files that were there before; those that are there now are added.
        num_kills: How many processes were killed since: each may have left one.
    """
    rest = {file for pattern in ("*.tmp", "tmp*", ".*") for file in data.rglob(pattern)} - known
    known |= rest
    if len(rest) <= num_kills:
        return []
    return [
        Violation("nothing is left behind", str(file.relative_to(data)), "is in the data folder")
        for file in sorted(rest)
    ]


def _jobs(database: Database, ends: Mapping[str, str]) -> Iterator[Violation]:
    rows = dict(_pairs(database, "SELECT id, state FROM jobs"))
    for identifier, end in ends.items():
        state = rows.pop(identifier, "nothing")
        if state != _STATES.get(end, end):
            yield Violation(
                "every job has one end", identifier, f"was {end}, the table has {state}"
            )
    for identifier, state in rows.items():
        what = f"is {state} in the table, and was not asked for"
        yield Violation("none is doubled", identifier, what)


def _parts(database: Database) -> Iterator[Violation]:
    for part in _PARTS:
        query = f"SELECT DISTINCT job, '' FROM {part} WHERE job NOT IN (SELECT id FROM jobs)"
        for identifier, _ in _pairs(database, query):
            yield Violation("nothing is left behind", identifier, f"is no job, and has {part}")
    for part in _PARTS[:2]:
        query = f"SELECT id, state FROM jobs WHERE id NOT IN (SELECT job FROM {part})"
        for identifier, _ in _pairs(database, query):
            yield Violation("every log is whole", identifier, f"has no {part}")
    query = (
        "SELECT id, num_events FROM jobs WHERE num_events != "
        "(SELECT count(*) FROM job_events WHERE job_events.job = jobs.id)"
    )
    for identifier, count in _pairs(database, query):
        yield Violation(
            "every log is whole", identifier, f"should have {count} events in the table"
        )


def _sound(database: Database) -> Iterator[Violation]:
    if database.name == "sqlite":
        [[verdict]] = database.rows("PRAGMA integrity_check")
        if verdict != "ok":
            yield Violation("the database is sound", "sqlite", str(verdict))
    [[is_released]] = database.rows("SELECT is_released FROM job_owner")
    if not is_released:
        yield Violation("a server ends when it is told to", "server", "it kept the database")


def _pairs(database: Database, query: str) -> Iterator[tuple[str, Any]]:
    yield from ((row[0], row[1]) for row in database.rows(query))
