"""Databases that are full, locked by another connection, or old, when a test says so."""

import sqlite3
import threading
from contextlib import contextmanager

from sqlalchemy import event

from service.jobs.store.sql.migrations.versions import r0001_released as released


class FullDisk:
    """Lets a SQLite database grow no further while it is set."""

    def __init__(self, engine):
        self._is_full = threading.Event()
        event.listen(engine, "begin", self._limit)

    def fill(self):
        self._is_full.set()

    def free(self):
        self._is_full.clear()

    def _limit(self, connection):
        # A limit below what there is means: what there is.
        pages = 1 if self._is_full.is_set() else 2**30
        connection.exec_driver_sql(f"PRAGMA max_page_count={pages}").close()


@contextmanager
def locked(file):
    """Hold the write lock of a SQLite database from another connection."""
    other = sqlite3.connect(file, isolation_level=None)
    try:
        other.execute("BEGIN IMMEDIATE")
        yield
        other.execute("ROLLBACK")
    finally:
        other.close()


FORMER_NAMES = {
    "service.tasks.plan:plan_motion": "plan",
    "service.tasks.reverse:reverse_motion": "reverse",
    "service.tasks.regions:grow": "grow_regions",
    "service.tasks.execute:execute": "execute",
}
_FORMER_COLUMNS = {
    "serial": "sequence",
    "lane": "queue",
    "warm_key": "world_digest",
    "allowed": "time_limit",
}


def make_released(engine):
    """Have a database of this version, with its jobs, be as version 0.1 would have left it.

    But for its revision, 0001, which that version did not store. It has no scenes then.
    """
    renamed = [
        f"ALTER TABLE jobs RENAME COLUMN {name} TO {former}"
        for former, name in _FORMER_COLUMNS.items()
    ]
    tasks = [
        f"UPDATE jobs SET task = '{path}' WHERE task = '{FORMER_NAMES[path]}'"
        for path in FORMER_NAMES
    ]
    with engine.begin() as connection:
        for statement in (
            "DROP TABLE webhooks",
            "DROP TABLE webhook_notices",
            "DROP INDEX jobs_of_batch",
            *(
                f"ALTER TABLE jobs DROP COLUMN {name}"
                for name in ("client", "batch", "cancel_requested_at")
            ),
            "DROP TABLE api_keys",
            "DROP TABLE job_robots",
            "DROP TABLE scene_entries",
            "DROP INDEX jobs_of_queue",
            *renamed,
            "CREATE INDEX jobs_of_lane ON jobs (lane, serial)",
            "ALTER TABLE job_summaries RENAME TO job_briefs",
            *tasks,
            "UPDATE alembic_version SET version_num = '0001'",
            "DROP TABLE artifacts",
            "DROP TABLE scene_states",
            "DROP TABLE scenes",
        ):
            connection.exec_driver_sql(statement)
        released.metadata.tables["scenes"].create(connection)
