"""Writes `new_sqlite.py`: the statements that make what all revisions leave."""

import sys
import tempfile
from functools import partial
from pathlib import Path
from textwrap import wrap

from sqlalchemy import Engine, create_engine, text

from service.jobs.store.sql.migrations.upgrade import upgrade

TARGET = Path(__file__).with_name("new_sqlite.py")
_wrapped = partial(wrap, width=96, break_long_words=False)
# Tables first; revisions make indices in no order.
_MADE = "SELECT sql FROM sqlite_master WHERE sql IS NOT NULL ORDER BY type DESC, name"


def statements_of(engine: Engine) -> str:
    """Return what a SQLite database says that its tables and indices were made by, in order."""
    with engine.connect() as connection:
        found = [_tidy(sql) for sql in connection.scalars(text(_MADE))]
    return "".join(f"{sql};\n" for sql in found)


def snapshot() -> str:
    """Return the statements that make what all revisions leave of an empty SQLite database."""
    with tempfile.TemporaryDirectory() as folder:
        engine = create_engine(f"sqlite:///{folder}/new.sqlite")
        try:
            upgrade(engine)
            return statements_of(engine)
        finally:
            engine.dispose()


def _tidy(statement: str) -> str:
    statement = statement.replace("CREATE TABLE ", "CREATE TABLE IF NOT EXISTS ", 1)
    lines = [line.expandtabs(4) for line in statement.splitlines()]
    return "\n".join(part for line in lines for part in _wrapped(line, subsequent_indent="    "))


def write() -> None:
    """Write them."""
    module = TARGET.read_text(encoding="utf-8")
    head = module[: module.index("STATEMENTS")]
    TARGET.write_text(f'{head}STATEMENTS = """\\\n{snapshot()}"""\n', encoding="utf-8")


if __name__ == "__main__":
    write()
    sys.stderr.write(f"written: {TARGET.name}\n")
