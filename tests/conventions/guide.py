"""What the pages of the guide show of HTTP: calls, bodies and parts of bodies."""

import json
import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any
from urllib.parse import parse_qsl, urlsplit

ROOT = Path(__file__).parents[2]
# Pages whose code tests of their own run, with a server or as commands.
_ELSEWHERE = {"client.md", "generate-a-client.md", "live-state.md", "cli.md"}
_FOLDERS = ("tutorial", "how-to", "reference", "explanation")
PAGES = [
    ROOT / "README.md",
    *(
        page
        for folder in _FOLDERS
        for page in sorted((ROOT / "docs" / folder).rglob("*.md"))
        if page.name not in _ELSEWHERE
    ),
]

_CURL = re.compile(r"^ *(curl (?:[^\n'\\]|'[^']*'|\\\n)*)", re.MULTILINE)
_JSON = re.compile(r"```json\n(.*?)```", re.DOTALL)
# A member of an object, set off as code by four blanks, with the lines that go on with it.
_MEMBER = re.compile(r'(?<=\n\n)(?: {4}"\w+": [^\n]*(?:\n {4}[^\n]+)*)(?=\n\n)')


@dataclass(frozen=True)
class Call:
    """A call of curl: its `method`, `path`, `query`, and its `body` if that is JSON."""

    method: str
    path: str
    query: dict[str, str]
    body: Any = None


def calls(page: Path) -> Iterator[Call]:
    """Yield the calls of a page."""
    for found in _CURL.finditer(page.read_text()):
        words = shlex.split(found[1])
        [url] = [word for word in words if word.startswith("http://")]
        options = dict(pairwise(words))
        sends = {"-d", "--data-binary"} & set(words)
        yield Call(
            options.get("-X", "POST" if sends else "GET"),
            urlsplit(url).path,
            dict(parse_qsl(urlsplit(url).query)),
            json.loads(options["-d"]) if "-d" in words else None,
        )


def values(page: Path) -> Iterator[Any]:
    """Yield what the JSON blocks of a page say; a block may have several values."""
    decoder = json.JSONDecoder()
    for text in _JSON.findall(page.read_text()):
        rest = text.strip()
        while rest:
            value, end = decoder.raw_decode(rest)
            yield value
            rest = rest[end:].strip()


def members(page: Path) -> Iterator[dict[str, Any]]:
    """Yield the members of objects that a page sets off; those with `...` are left out."""
    for text in _MEMBER.findall(page.read_text()):
        if "..." not in text:
            yield json.loads("{" + text + "}")
