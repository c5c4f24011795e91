"""Failures that commands tell, each in a data folder of its own."""

import gzip
import os
import sqlite3
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.error_runs.made import Printed
from benchmarks.error_runs.serving import asked

_ROOT = Path(__file__).resolve().parents[2]
# Shown instead of folders that are gone.
_SHOWN = "/var/lib/wayproof"
_LONGEST = 120.0
_NEWER = "update alembic_version set version_num = '9999'"
_FOREIGN = "create table jobs (id integer primary key, done boolean)"
_RECORDS = "wayproof.sqlite"


def commands() -> Iterator[Printed]:
    """Yield what is told so."""
    with TemporaryDirectory(prefix="wayproof-errors-", ignore_cleanup_errors=True) as name:
        own, newer, foreign = (Path(name) / each for each in ("own", "newer", "foreign"))
        for folder in (own, newer, foreign):
            folder.mkdir()
        create = "keys create ci --scope plan"
        _printed(create, own)
        _printed(create, newer)
        yield Printed("key_exists", *_printed(create, own))
        with asked({}, own):
            yield Printed("database_in_use", *_printed("serve --port 0", own))
        _printed("backup records.sqlite.gz", own)
        yield Printed("records_exist", *_printed("restore records.sqlite.gz", own))
        (foreign / "other.sqlite.gz").write_bytes(gzip.compress(b"of another program"))
        yield Printed("backup_invalid", *_printed("restore other.sqlite.gz", foreign))
        yield Printed("unguarded", *_printed("serve --host 0.0.0.0 --port 0", own))
        _change(newer, _NEWER)
        yield Printed("database_too_new", *_printed("serve --port 0", newer))
        _change(foreign, _FOREIGN)
        yield Printed("database_unrecognized", *_printed("serve --port 0", foreign))
        other = {"WAYPROOF_DATABASE_URL": "postgresql://db.example/wayproof"}
        yield Printed("backup_impossible", *_printed("backup records.sqlite.gz", own, other))


def _printed(
    arguments: str, folder: Path, more: Mapping[str, str] | None = None
) -> tuple[str, str]:
    """Return a command as it is typed, and what it says on a data folder."""
    environment = {**os.environ, "PYTHONPATH": str(_ROOT), "WAYPROOF_DATA_DIR": str(folder)}
    ran = subprocess.run(
        [sys.executable, "-W", "ignore", "-m", "service", *arguments.split()],
        cwd=folder,
        env={**environment, **(more or {})},
        capture_output=True,
        text=True,
        timeout=_LONGEST,
        check=False,
    )
    typed = "".join(f"{name}={value} " for name, value in (more or {}).items())
    return f"{typed}wayproof {arguments}", ran.stderr.replace(str(folder), _SHOWN)


def _change(folder: Path, statement: str) -> None:
    """Have a database be as another program or version left it."""
    with closing(sqlite3.connect(folder / _RECORDS)) as database, database:
        database.execute(statement)
