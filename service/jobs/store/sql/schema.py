"""The revision of a database: it is brought to the newest, and one that is newer is refused."""

import logging

from sqlalchemy import Engine, column, insert, inspect, select, table, text

from service.jobs.errors import DatabaseTooNew
from service.jobs.store.sql.migrations.new_sqlite import STATEMENTS
from service.jobs.store.sql.tables import owner

# The number of the last file of `migrations/versions`; numbers of revisions have four digits.
NEWEST = "0010"
_VERSION = table("alembic_version", column("version_num"))
# Not those that SQLite makes for itself.
_TABLES = text("SELECT name FROM sqlite_master WHERE type = 'table' AND name NOT GLOB 'sqlite_*'")
_log = logging.getLogger(__name__)


def stored_revision(engine: Engine) -> str | None:
    """Return the revision of a database; None if it has none, as version 0.1 and before left it."""
    if not inspect(engine).has_table(_VERSION.name):
        return None
    with engine.connect() as connection:
        return connection.execute(select(_VERSION.c.version_num)).scalar()


def refuse_newer(engine: Engine) -> str | None:
    """Return the revision of a database that this version can open, None if it has none.

    Raises:
        DatabaseTooNew: A newer version has changed it.
    """
    stored = stored_revision(engine)
    if stored is not None and stored > NEWEST:
        raise DatabaseTooNew.of(stored, NEWEST)
    return stored


def is_up_to_date(engine: Engine) -> bool:
    """Return whether a database has the newest revision."""
    return stored_revision(engine) == NEWEST


def bring_up_to_date(engine: Engine) -> None:
    """Bring a database to the newest revision; one that is there is only looked at.

    Raises:
        DatabaseTooNew: A newer version has changed it.
        DatabaseUnrecognized: It has no revision, and tables that are not this program's.
    """
    stored = refuse_newer(engine)
    if stored == NEWEST or (stored is None and _make_new(engine)):
        return
    from service.jobs.store.sql.migrations.upgrade import upgrade  # noqa: PLC0415  (takes a quarter second)

    upgrade(engine)
    _log.info("brought the database from revision %s to %s", stored or "none", NEWEST)


def _make_new(engine: Engine) -> bool:
    """Make what an empty SQLite database lacks, without Alembic; return whether it was one.

    The owner's table may be there: who makes tables has taken the database before.
    """
    if engine.dialect.name != "sqlite":
        return False
    with engine.begin() as connection:
        # Python's driver begins a transaction at the first row that is written, not at a table.
        connection.exec_driver_sql("BEGIN IMMEDIATE")
        if set(connection.scalars(_TABLES)) - {owner.name}:
            return False
        for statement in STATEMENTS.split(";\n")[:-1]:
            connection.exec_driver_sql(statement)
        connection.execute(insert(_VERSION).values(version_num=NEWEST))
    return True
