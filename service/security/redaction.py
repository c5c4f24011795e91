"""Redaction: keys that come where none belongs, as in an address, are not written to logs."""

import logging
import re
from typing import override

_KEY = re.compile(r"(wp_[0-9a-f]{12}_)[A-Za-z0-9_-]{43}")


def redacted(text: str) -> str:
    """Return a text without the secrets of keys; which keys they were stays."""
    return _KEY.sub(r"\1...", text)


class KeyFilter(logging.Filter):
    """Redacts the message of a log record, its arguments and its traceback."""

    @override
    def filter(self, record: logging.LogRecord) -> bool:
        """Let every record pass."""
        if isinstance(record.msg, str):
            record.msg = redacted(record.msg)
        if isinstance(record.args, tuple):
            record.args = tuple(_redacted_argument(each) for each in record.args)
        if record.exc_info:
            record.exc_text = redacted(logging.Formatter().formatException(record.exc_info))
        return True


def _redacted_argument(argument: object) -> object:
    if isinstance(argument, BaseException):
        argument = str(argument)
    return redacted(argument) if isinstance(argument, str) else argument
