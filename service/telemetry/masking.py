"""Masking: keys, passwords and the like that come where none belongs are not written to logs."""

import re

_KEY = re.compile(r"(wp_[0-9a-f]{12}_)[A-Za-z0-9_-]{43}")
# JSON web tokens: what is signed stays, the signature does not.
_TOKEN = re.compile(r"\b(eyJ[A-Za-z0-9_-]+\.[A-Za-z0-9_-]+\.)[A-Za-z0-9_-]+")
# `scheme://user:secret@`, and whatever is said to be a secret.
_IN_URL = re.compile(r"(://[^\s:/@\"']*:)[^\s/\"']+(?=@)")
_NAMED = re.compile(
    r"((?:authorization|api[-_]?key|passw(?:or)?d|secret|token|cookie)\\?[\"']?\s*[:=]\s*\\?[\"']?"
    r"(?:(?:bearer|basic)\s+)?)[^\s\"'\\,;&)}\]]+",
    re.IGNORECASE,
)


def redacted(text: str) -> str:
    """Return a text without what makes keys and tokens good; which they were stays."""
    return _TOKEN.sub(r"\1...", _KEY.sub(r"\1...", text))


def masked(line: str) -> str:
    """Return a line without keys, passwords, tokens and the like."""
    return _NAMED.sub(r"\1***", _IN_URL.sub(r"\1***", redacted(line)))
