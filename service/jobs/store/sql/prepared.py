"""Prepared: statements made once, given straight to the driver of a database.

SQLAlchemy makes their text; what it does around each execution takes ten times as long as SQLite
needs for one row, which counts where it is on the way of every answer.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Any

from sqlalchemy import Connection, Insert, Select, Update
from sqlalchemy.exc import DBAPIError
from sqlalchemy.sql.compiler import SQLCompiler


class Rows:
    """What a statement returned: rows as mappings of their columns, in order."""

    def __init__(self, columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
        """Hold rows of columns."""
        self._columns = columns
        self._rows = rows

    def first(self) -> dict[str, Any] | None:
        """Return the first row by the names of its columns, None if there is none."""
        return dict(zip(self._columns, self._rows[0], strict=True)) if self._rows else None

    def scalar(self) -> Any:
        """Return the first column of the first row, None if there is none."""
        return self._rows[0][0] if self._rows else None


class Prepared:
    """A statement with named parameters; JSON goes in as text, and comes out as text."""

    def __init__(self, statement: Insert | Select[Any] | Update, *names: str) -> None:
        """Prepare a statement.

        Args:
            statement: With its parameters bound, or an insert of whole rows.
            names: Columns of an insert; none where the statement says which.
        """
        self._statement = statement
        self._names = list(names) or None
        self._known: dict[str, _Text] = {}

    def __call__(self, connection: Connection, **given: Any) -> Rows:
        """Carry it out in the transaction of a connection, with these parameters.

        Raises:
            DBAPIError: The database does not take it.
        """
        known = self._in(connection)
        parameters = known.parameters(given)
        with _Cursor(connection, known.text, parameters) as cursor:
            cursor.execute(known.text, parameters)
            if cursor.description is None:
                return Rows((), ())
            return Rows([column[0] for column in cursor.description], cursor.fetchall())

    def many(self, connection: Connection, rows: Sequence[Mapping[str, Any]]) -> None:
        """Carry it out for each of some rows of parameters; raises as a call."""
        known = self._in(connection)
        given = [known.parameters(row) for row in rows]
        with _Cursor(connection, known.text, given) as cursor:
            cursor.executemany(known.text, given)

    def _in(self, connection: Connection) -> "_Text":
        """Return the statement as the database of a connection has it."""
        dialect = connection.dialect
        if dialect.name not in self._known:
            made = self._statement.compile(dialect=dialect, column_keys=self._names)
            assert isinstance(made, SQLCompiler)  # noqa: S101  (it is a statement)
            names = None if made.positiontup is None else tuple(made.positiontup)
            self._known[dialect.name] = _Text(str(made), dict(made.params), names)
        return self._known[dialect.name]


class _Cursor:
    """A cursor of a connection's driver, whose errors are SQLAlchemy's."""

    def __init__(self, connection: Connection, text: str, parameters: Any) -> None:
        # The driver begins a transaction by itself; SQLAlchemy is to know that there is one to end.
        if not connection.in_transaction():
            connection.begin()
        self._connection = connection
        self._asked = (text, parameters)
        self._cursor: Any = connection.connection.cursor()

    def __enter__(self) -> Any:
        return self._cursor

    def __exit__(
        self,
        kind: type[BaseException] | None,
        fault: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._cursor.close()
        driver = self._connection.dialect.dbapi
        if driver is not None and isinstance(fault, driver.Error):
            error = DBAPIError.instance(*self._asked, fault, driver.Error)
            raise error.with_traceback(trace) from fault


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
