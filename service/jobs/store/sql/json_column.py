"""JsonText: a column of JSON text; apart from `json_text`, so that workers import no SQL."""

from typing import Any, override

from sqlalchemy import Dialect, Text
from sqlalchemy.types import TypeDecorator

from service.jobs.json_steps import decode
from service.jobs.json_text import Encoded, encode


class JsonText(TypeDecorator[Any]):
    """A column of JSON text; unlike databases' own JSON types it changes no byte of it."""

    impl = Text
    cache_ok = True

    @override
    def process_bind_param(self, value: Any, dialect: Dialect) -> str | None:
        if value is None:
            return None
        return value.text if isinstance(value, Encoded) else encode(value)

    @override
    def process_result_value(self, value: Any, dialect: Dialect) -> Any:
        return None if value is None else decode(value)
