"""Databases that are full, or locked by another connection, when a test says so."""

import sqlite3
import threading
from contextlib import contextmanager

from sqlalchemy import event


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
