"""One dispatcher per database."""

import fcntl
from pathlib import Path
from typing import Any

from sqlalchemy import Engine, text

from service.jobs.errors import DatabaseInUse

# Any number will do, as long as every dispatcher uses the same.
_ADVISORY_KEY = 0x57_61_79_70


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
            self._held.close()
            self._held = None

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
        connection = self._engine.connect()
        taken = connection.execute(
            text("SELECT pg_try_advisory_lock(:key)"), {"key": _ADVISORY_KEY}
        ).scalar_one()
        if not taken:
            connection.close()
            raise self._in_use()
        return connection

    def _in_use(self) -> DatabaseInUse:
        database = self._engine.url.render_as_string(hide_password=True)
        message = f"another server works on {database}; stop it, or choose another data folder"
        return DatabaseInUse(message, {"database": database})
