"""Entries: which robots the open jobs of a scene move, so that no robot is moved by two of them.

What enters a scene locks a row of that scene until the commit, and counts it up. So a request knows
what moves there: it has looked, and if another job has entered since then the number is another one
and it is refused. A job may wait for its robots; then it has its place behind those that came
before it, and enters once it is released.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from sqlalchemy import Connection, bindparam, insert, select, update
from sqlalchemy.dialects import postgresql

from service.jobs.states import JobState
from service.jobs.store.sql.tables import job_robots, jobs, scene_entries

_OPEN = [state.value for state in JobState if not state.is_final]
# SQLite says it alike.
_ADD_SCENE = postgresql.insert(scene_entries).on_conflict_do_nothing()
_NUMBER = select(scene_entries.c.number).where(scene_entries.c.scene == bindparam("in_scene"))
_OF_SCENE = (
    select(jobs.c.id, jobs.c.sequence, jobs.c.state, job_robots.c.robot, job_robots.c.is_waiting)
    .join(job_robots, job_robots.c.job == jobs.c.id)
    .where(
        jobs.c.queue == bindparam("in_queue"),
        jobs.c.scene == bindparam("in_scene"),
        jobs.c.state.in_(_OPEN),
    )
    .order_by(jobs.c.sequence)
)
# Whether a job waits for its robots, and is not to be run before it is released.
WAITS_FOR_ROBOTS = (jobs.c.state == JobState.QUEUED.value) & (
    select(job_robots.c.job).where(job_robots.c.job == jobs.c.id, job_robots.c.is_waiting).exists()
)


@dataclass(frozen=True)
class Entry:
    """How a job enters its scene.

    Attributes:
        robots: That it moves.
        follows: How many jobs had entered the scene when the request looked; None if that is no
            matter.
        waits: Whether it waits for its robots.
    """

    robots: Collection[str]
    follows: int | None
    waits: bool


@dataclass(frozen=True)
class OpenEntry:
    """A job that has not ended.

    Attributes:
        job: Its id.
        sequence: Of the job.
        robots: That it moves.
        is_waiting: Whether it waits for them.
    """

    job: str
    sequence: int
    robots: frozenset[str]
    is_waiting: bool


@dataclass(frozen=True)
class Entries:
    """What moves in a scene, or waits to.

    Attributes:
        number: How many jobs have entered it.
        open: Those that have not ended, and those that wait, oldest first.
    """

    number: int
    open: Sequence[OpenEntry]

    def in_the_way(self, robots: Collection[str]) -> OpenEntry | None:
        """Return the oldest job that moves one of some robots, or waits for one."""
        return next((entry for entry in self.open if entry.robots & set(robots)), None)

    def is_free_for(self, job: str) -> bool:
        """Return whether a job that waits may enter: it is the next one for all its robots."""
        own = next((entry for entry in self.open if entry.job == job and entry.is_waiting), None)
        return own is not None and not any(
            entry.robots & own.robots and (not entry.is_waiting or entry.sequence < own.sequence)
            for entry in self.open
            if entry.job != job
        )


def read_entries(connection: Connection, queue: str, scene: str) -> Entries:
    """Return what moves in a scene; what enters it later than its number was read may be in it."""
    number = connection.execute(_NUMBER, {"in_scene": scene}).scalar()
    robots: dict[str, set[str]] = {}
    rows = connection.execute(_OF_SCENE, {"in_queue": queue, "in_scene": scene}).all()
    for row in rows:
        robots.setdefault(row.id, set()).add(row.robot)
    found = {
        row.id: OpenEntry(row.id, row.sequence, frozenset(robots[row.id]), row.is_waiting)
        for row in rows
    }
    return Entries(number or 0, list(found.values()))


def enter(connection: Connection, queue: str, scene: str, entry: Entry) -> bool:
    """Let a job enter a scene that is not in the table yet; return whether it may.

    Nothing else enters the scene before the commit.
    """
    if not lock_entries(connection, scene, entry.follows, more=not entry.waits):
        return False
    return entry.waits or (read_entries(connection, queue, scene).in_the_way(entry.robots) is None)


def lock_entries(connection: Connection, scene: str, follows: int | None, *, more: bool) -> bool:
    """Let nothing else enter a scene before the commit; return whether its number is as expected.

    Args:
        connection: In a transaction.
        scene: Its id.
        follows: The number that is expected; None for any.
        more: Whether a job enters now.
    """
    connection.execute(_ADD_SCENE, {"scene": scene, "number": 0})
    statement = update(scene_entries).where(scene_entries.c.scene == scene)
    if follows is not None:
        statement = statement.where(scene_entries.c.number == follows)
    changed = statement.values(number=scene_entries.c.number + int(more))
    return connection.execute(changed).rowcount == 1


def write_robots(connection: Connection, job: str, entry: Entry) -> None:
    """Note which robots a job moves, or waits for."""
    rows = [
        {"job": job, "robot": robot, "is_waiting": entry.waits} for robot in sorted(entry.robots)
    ]
    connection.execute(insert(job_robots), rows)


def write_released(connection: Connection, job: str) -> None:
    """Note that a job waits for its robots no longer."""
    own = update(job_robots).where(job_robots.c.job == job)
    connection.execute(own.values(is_waiting=False))
