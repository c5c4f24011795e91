"""upgrade(): Alembic brings a database to a revision, in one transaction or not at all.

Apart from `service.jobs.store.sql.schema`, because Alembic takes a quarter of a second to import.
"""

from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.script import ScriptDirectory
from sqlalchemy import Engine

_FOLDER = Path(__file__).parent


def upgrade(engine: Engine, revision: str = "head") -> None:
    """Bring a database to a revision that is not older than its own.

    Raises:
        DatabaseUnrecognized: It has no revision, and tables that are not this program's.
    """
    with engine.begin() as connection:
        if connection.dialect.name == "sqlite":
            # Python's driver begins a transaction at the first row that is written, not at a table.
            connection.exec_driver_sql("BEGIN IMMEDIATE")
        config = _config()
        config.attributes["connection"] = connection
        command.upgrade(config, revision)


def head() -> str | None:
    """Return the newest revision that there is a file for."""
    return ScriptDirectory.from_config(_config()).get_current_head()


def _config() -> Config:
    config = Config()
    config.set_main_option("script_location", str(_FOLDER).replace("%", "%%"))
    return config
