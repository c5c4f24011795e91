"""Prepared: a statement that is made once, because to make it takes longer than to carry it out.

SQLAlchemy spends a tenth of a millisecond and more on each statement that it knows already. What
every job needs a dozen of is turned into the database's own text once; nothing is converted then.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import Connection, CursorResult, Insert, Select, Update
from sqlalchemy.sql.compiler import SQLCompiler


class Prepared:
    """A statement with named parameters; JSON goes in as text, and comes out as text."""

    def __init__(self, statement: Insert | Select[Any] | Update, *names: str) -> None:
        """Prepare a statement.

        Args:
            statement: What to carry out, on any database.
            names: The columns that an insert gives.
        """
        self._statement = statement
        self._names = list(names) or None
        self._compiled: dict[str, SQLCompiler] = {}

    def __call__(self, connection: Connection, **given: Any) -> CursorResult[Any]:
        """Carry it out in a transaction, with these parameters."""
        compiled = self._in(connection)
        return connection.exec_driver_sql(str(compiled), _parameters(compiled, given))

    def many(self, connection: Connection, rows: Sequence[Mapping[str, Any]]) -> None:
        """Carry it out for each of some rows of parameters."""
        compiled = self._in(connection)
        parameters = [_parameters(compiled, row) for row in rows]
        connection.exec_driver_sql(str(compiled), parameters)

    def _in(self, connection: Connection) -> SQLCompiler:
        """Return the statement as the database of a connection has it."""
        dialect = connection.dialect
        known = self._compiled.get(dialect.name)
        if known is None:
            known = self._statement.compile(dialect=dialect, column_keys=self._names)
            assert isinstance(known, SQLCompiler)  # noqa: S101  (it is a statement)
            self._compiled[dialect.name] = known
        return known


def _parameters(compiled: SQLCompiler, given: Mapping[str, Any]) -> Any:
    every = {**compiled.params, **given}
    if compiled.positiontup is None:
        return every
    return tuple(every[name] for name in compiled.positiontup)
