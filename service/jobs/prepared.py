"""Prepared: a statement that is made once, because to make it takes longer than to carry it out.

SQLAlchemy spends a tenth of a millisecond and more on each statement that it knows already. What
every job needs a dozen of is turned into the database's own text once; nothing is converted then.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
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
        self._known: dict[str, _Text] = {}

    def __call__(self, connection: Connection, **given: Any) -> CursorResult[Any]:
        """Carry it out in a transaction, with these parameters."""
        known = self._in(connection)
        return connection.exec_driver_sql(known.text, known.parameters(given))

    def many(self, connection: Connection, rows: Sequence[Mapping[str, Any]]) -> None:
        """Carry it out for each of some rows of parameters."""
        known = self._in(connection)
        given = [known.parameters(row) for row in rows]
        connection.exec_driver_sql(known.text, given if len(given) > 1 else given[0])

    def _in(self, connection: Connection) -> "_Text":
        """Return the statement as the database of a connection has it."""
        dialect = connection.dialect
        if dialect.name not in self._known:
            made = self._statement.compile(dialect=dialect, column_keys=self._names)
            assert isinstance(made, SQLCompiler)  # noqa: S101  (it is a statement)
            names = None if made.positiontup is None else tuple(made.positiontup)
            self._known[dialect.name] = _Text(str(made), dict(made.params), names)
        return self._known[dialect.name]


@dataclass(frozen=True)
class _Text:
    """A statement in the language of one database.

    Attributes:
        text: The statement.
        constants: Parameters that are always the same, by name.
        names: Of all parameters in their order, if they go by their places.
    """

    text: str
    constants: Mapping[str, Any]
    names: tuple[str, ...] | None

    def parameters(self, given: Mapping[str, Any]) -> Any:
        every = {**self.constants, **given}
        return every if self.names is None else tuple([every[name] for name in self.names])
