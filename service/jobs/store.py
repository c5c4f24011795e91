"""JobStore: the system of record. States change by compare-and-set, final ones are written once."""

import secrets
import threading
from collections.abc import Generator
from contextlib import contextmanager
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import (
    Connection,
    CursorResult,
    Engine,
    Row,
    create_engine,
    event,
    func,
    insert,
    select,
    update,
)

from service.jobs.errors import IdempotencyConflict, UnknownJob
from service.jobs.records import Job, JobSpec, LoggedEvent, events, jobs, metadata
from service.jobs.states import TRANSITIONS, JobEvent, JobState, advance

_FINISHED = "finished"


def open_engine(url: str) -> Engine:
    """Return an engine whose accepted writes survive a power cut."""
    engine = create_engine(url, future=True)
    if engine.dialect.name == "sqlite":

        def prepare(connection: Any, _: Any) -> None:
            for pragma in ("journal_mode=WAL", "synchronous=FULL", "busy_timeout=10000"):
                connection.execute(f"PRAGMA {pragma}")

        event.listen(engine, "connect", prepare)
    return engine


class JobStore:
    """Jobs and their events in a database; every method is one transaction, from any thread."""

    def __init__(self, engine: Engine) -> None:
        """Keep jobs in `engine`; call `open` before use."""
        self._engine = engine
        self._lock = threading.RLock()

    def open(self) -> None:
        """Create the tables that are missing."""
        metadata.create_all(self._engine)

    def insert(self, spec: JobSpec) -> tuple[Job, bool]:
        """Return a new queued job and True, or the one that the idempotency key names and False.

        Raises:
            IdempotencyConflict: The key was used for another request.
        """
        with self._write() as connection:
            known = self._by_key(connection, spec)
            if known is not None:
                return known, False
            row: dict[str, Any] = {
                **{name: getattr(spec, name) for name in _COPIED},
                "id": f"{spec.prefix}_{secrets.token_hex(10)}",
                "attempts": 0,
                "state": JobState.QUEUED.value,
                "stage": "",
                "progress": 0.0,
                "is_cancel_requested": False,
                "created_at": _now(),
            }
            connection.execute(insert(jobs).values(row))
            self._log(connection, row["id"], "queued", {})
            return self._get(connection, row["id"]), True

    def known(self, lane: str, key: str, request_digest: str) -> Job | None:
        """Return the job that an idempotency key names, if there is one.

        Raises:
            IdempotencyConflict: The key was used for another request.
        """
        with self._engine.connect() as connection:
            spec = JobSpec(lane, "", {}, key=key, request_digest=request_digest)
            return self._by_key(connection, spec)

    def get(self, identifier: str) -> Job:
        """Return a job.

        Raises:
            UnknownJob: There is none.
        """
        with self._engine.connect() as connection:
            return self._get(connection, identifier)

    def page(
        self,
        lane: str,
        *,
        state: str | None = None,
        scene: str | None = None,
        before: int | None = None,
        limit: int = 50,
    ) -> list[Job]:
        """Return jobs of a lane, newest first, with a serial below `before`."""
        query = select(jobs).where(jobs.c.lane == lane)
        query = query.where(jobs.c.state == state) if state else query
        query = query.where(jobs.c.scene == scene) if scene else query
        query = query.where(jobs.c.serial < before) if before is not None else query
        with self._engine.connect() as connection:
            found = connection.execute(query.order_by(jobs.c.serial.desc()).limit(limit))
            return [_job(row) for row in found]

    def unfinished(self) -> list[Job]:
        """Return every job that is queued or running, oldest first."""
        states = [state.value for state in JobState if not state.is_final]
        query = select(jobs).where(jobs.c.state.in_(states)).order_by(jobs.c.serial)
        with self._engine.connect() as connection:
            return [_job(row) for row in connection.execute(query)]

    def counts(self) -> dict[tuple[str, str], int]:
        """Return how many jobs there are by lane and state."""
        query = select(jobs.c.lane, jobs.c.state, func.count()).group_by(jobs.c.lane, jobs.c.state)
        with self._engine.connect() as connection:
            return {(lane, state): number for lane, state, number in connection.execute(query)}

    def move(
        self,
        identifier: str,
        happened: JobEvent,
        *,
        result: dict[str, Any] | None = None,
        failure: dict[str, Any] | None = None,
    ) -> Job | None:
        """Apply an event if the job's state allows it; None if the job has moved on meanwhile."""
        before = [state for state, event_ in TRANSITIONS if event_ is happened]
        after = advance(before[0], happened)
        changes: dict[str, Any] = {"state": after.value}
        if happened is JobEvent.START:
            changes |= {"started_at": _now(), "attempts": jobs.c.attempts + 1}
        if after.is_final:
            changes |= {"finished_at": _now(), "result": result, "failure": failure}
            changes |= {"progress": 1.0} if after is JobState.SUCCEEDED else {}
        guard = jobs.c.state.in_([state.value for state in before])
        with self._write() as connection:
            statement = update(jobs).where(jobs.c.id == identifier, guard).values(changes)
            done: CursorResult[Any] = connection.execute(statement)
            if done.rowcount != 1:
                return None
            name, data = _EVENT_NAMES[happened], {}
            if after.is_final:
                data = {"state": after.value, **({"failure": failure} if failure else {})}
            self._log(connection, identifier, name, data)
            return self._get(connection, identifier)

    def request_cancel(self, identifier: str) -> Job:
        """Note that somebody wants the end of a job, and return it.

        Raises:
            UnknownJob: There is none.
        """
        with self._write() as connection:
            statement = update(jobs).where(jobs.c.id == identifier)
            connection.execute(statement.values(is_cancel_requested=True))
            return self._get(connection, identifier)

    def record(self, identifier: str, type_: str, data: dict[str, Any]) -> LoggedEvent | None:
        """Append what a running job says; None if it has ended meanwhile.

        `stage` and `progress` in the data become the job's.
        """
        changes = {name: data[name] for name in ("stage", "progress") if name in data}
        with self._write() as connection:
            is_running = (jobs.c.id == identifier) & (jobs.c.state == JobState.RUNNING.value)
            if connection.execute(select(jobs.c.serial).where(is_running)).first() is None:
                return None
            if changes:
                connection.execute(update(jobs).where(is_running).values(changes))
            return self._log(connection, identifier, type_, data)

    def events(self, identifier: str, after: int = 0) -> list[LoggedEvent]:
        """Return a job's events with numbers above `after`, in order."""
        query = select(events).where(events.c.job == identifier, events.c.number > after)
        with self._engine.connect() as connection:
            found = connection.execute(query.order_by(events.c.number))
            return [_event(row) for row in found]

    def last_event(self, identifier: str, type_: str) -> LoggedEvent | None:
        """Return the newest event of a type, if there is one."""
        query = select(events).where(events.c.job == identifier, events.c.type == type_)
        with self._engine.connect() as connection:
            row = connection.execute(query.order_by(events.c.number.desc()).limit(1)).first()
            return None if row is None else _event(row)

    @contextmanager
    def _write(self) -> Generator[Connection]:
        with self._lock, self._engine.begin() as connection:
            yield connection

    def _get(self, connection: Connection, identifier: str) -> Job:
        row = connection.execute(select(jobs).where(jobs.c.id == identifier)).first()
        if row is None:
            message = f"there is no job {identifier!r}"
            raise UnknownJob(message, {"id": identifier})
        return _job(row)

    def _by_key(self, connection: Connection, spec: JobSpec) -> Job | None:
        if spec.key is None:
            return None
        named = (jobs.c.lane == spec.lane) & (jobs.c.key == spec.key)
        row = connection.execute(select(jobs).where(named)).first()
        if row is None:
            return None
        known = _job(row)
        if known.request_digest != spec.request_digest:
            message = f"the idempotency key {spec.key!r} was used for another request: {known.id}"
            raise IdempotencyConflict(message, {"key": spec.key, "job": known.id})
        return known

    def _log(
        self, connection: Connection, identifier: str, type_: str, data: dict[str, Any]
    ) -> LoggedEvent:
        newest = select(func.coalesce(func.max(events.c.number), 0)).where(
            events.c.job == identifier
        )
        number = int(connection.execute(newest).scalar_one()) + 1
        logged = LoggedEvent(identifier, number, type_, data, _now())
        connection.execute(insert(events).values(**logged.__dict__))
        return logged


_COPIED = (
    "lane",
    "task",
    "payload",
    "scene",
    "warm_key",
    "priority",
    "allowed",
    "max_attempts",
    "key",
    "request_digest",
)
_EVENT_NAMES = {
    JobEvent.START: "started",
    JobEvent.REQUEUE: "requeued",
    JobEvent.SUCCEED: _FINISHED,
    JobEvent.FAIL: _FINISHED,
    JobEvent.CANCEL: _FINISHED,
}


def _job(row: Row[Any]) -> Job:
    fields: dict[str, Any] = row_dict(row)
    for name in ("created_at", "started_at", "finished_at"):
        fields[name] = datetime.fromisoformat(fields[name]) if fields[name] else None
    fields["state"] = JobState(fields["state"])
    return Job(**fields)


def _event(row: Row[Any]) -> LoggedEvent:
    return LoggedEvent(**row_dict(row))


def row_dict(row: Row[Any]) -> dict[str, Any]:
    """Return a row by column name."""
    return dict(row._mapping)  # noqa: SLF001  # pyright: ignore[reportPrivateUsage]  (public)


def _now() -> str:
    return datetime.now(UTC).isoformat()
