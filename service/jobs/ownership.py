"""One dispatcher per database."""

import fcntl
import threading
from pathlib import Path
from typing import Any

from sqlalchemy import Engine, text

from service.jobs.errors import DatabaseInUse

# Any number will do, as long as every dispatcher uses the same.
_ADVISORY_KEY = 0x57_61_79_70
_ADVISORY_TRIES, _ADVISORY_PAUSE = 20, 0.1


class Ownership:
    """Holds a database for one dispatcher until released, or until its process ends."""

    def __init__(self, engine: Engine) -> None:
        """Take nothing yet."""
        self._engine = engine
        self._held: Any = None

    def take(self) -> None:
        """Take the database.

        Raises:
            DatabaseInUse: Another dispatcher has it.
        """
        if self._engine.dialect.name == "sqlite":
            self._held = self._lock_file()
        elif self._engine.dialect.name == "postgresql":
            self._held = self._lock_advisory()

    def release(self) -> None:
        """Give it back."""
        if self._held is not None:
            held, self._held = self._held, None
            if self._engine.dialect.name == "postgresql":
                self._release_advisory(held)
            else:
                held.close()

    def _lock_file(self) -> Any:
        database = self._engine.url.database
        if not database or database == ":memory:":
            return None
        file = Path(f"{database}.lock").open("w")  # noqa: SIM115  (held, and closed by release)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as fault:
            file.close()
            raise self._in_use() from fault
        return file

    def _lock_advisory(self) -> Any:
        # Outside of a transaction, which would otherwise be open as long as the server runs.
        connection = self._engine.connect().execution_options(isolation_level="AUTOCOMMIT")
        lock = text("SELECT pg_try_advisory_lock(:key)")
        # The database may need a moment to notice that an earlier server has died.
        for _ in range(_ADVISORY_TRIES):
            if connection.execute(lock, {"key": _ADVISORY_KEY}).scalar_one():
                return connection
            threading.Event().wait(_ADVISORY_PAUSE)
        connection.close()
        raise self._in_use()

    def _release_advisory(self, connection: Any) -> None:
        """Let go before the connection returns to the pool, which would keep the lock."""
        connection.execute(text("SELECT pg_advisory_unlock(:key)"), {"key": _ADVISORY_KEY})
        connection.close()

    def _in_use(self) -> DatabaseInUse:
        database = self._engine.url.render_as_string(hide_password=True)
        message = f"another server works on {database}; stop it, or choose another data folder"
        return DatabaseInUse(message, {"database": database})
