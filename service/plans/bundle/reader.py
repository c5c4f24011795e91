"""read_bundle(): the contents of a bundle, from its ZIP file or the folder it was unpacked to.

Names in the archive never become paths: contents are known by their sha256 alone. Sizes are those
of the bytes that come out, whatever the archive says of them.
"""

import hashlib
import json
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

from pydantic import ValidationError

from service.jobs.task import artifacts_of
from service.plans.bundle import contents
from service.plans.bundle.contents import Manifest
from service.plans.tasks import PLAN, REVERSE

# Of all contents together [bytes], and of entries.
MAX_BYTES, MAX_ENTRIES = 2**30, 20_000
_PLAIN = (contents.MANIFEST, contents.WORK, contents.RESULT)
_TASKS = {task.name: task for task in (PLAN, REVERSE)}


class BundleInvalid(ValueError):
    """It is no bundle, is damaged, or is too large; the message says which."""


@dataclass(frozen=True)
class Bundle:
    """A bundle in memory.

    Attributes:
        manifest: What it is of.
        work: What its task is given.
        result: Of a plan that succeeded.
        artifacts: All that its task reads, by sha256; each has this sha256.
    """

    manifest: Manifest
    work: dict[str, Any]
    result: dict[str, Any] | None
    artifacts: Mapping[str, bytes]


def read_bundle(path: Path, max_bytes: int = MAX_BYTES) -> Bundle:
    """Read a bundle.

    Args:
        path: A ZIP file, or a folder.
        max_bytes: Of all contents together.

    Raises:
        BundleInvalid: It is none, is damaged, or is too large.
    """
    try:
        entries = dict(_folder(path, max_bytes) if path.is_dir() else _archive(path, max_bytes))
        plain = {name: json.loads(entries[name]) for name in _PLAIN if name in entries}
        manifest, work = Manifest.model_validate(plain[contents.MANIFEST]), plain[contents.WORK]
        held = {
            hashlib.sha256(content).hexdigest(): content
            for name, content in entries.items()
            if name.startswith((f"{contents.FILES}/", f"{contents.ARTIFACTS}/"))
        }
        _require_whole(manifest, work, held)
    except (OSError, BadZipFile, zlib.error, RuntimeError, EOFError) as fault:
        message = f"{path}: it cannot be read: {fault}"
        raise BundleInvalid(message) from fault
    except KeyError as fault:
        message = f"{path}: it is no bundle, or not whole: it has no {fault}"
        raise BundleInvalid(message) from fault
    except (ValidationError, json.JSONDecodeError, UnicodeDecodeError) as fault:
        message = f"{path}: it is no bundle of format {contents.FORMAT}: {fault}"
        raise BundleInvalid(message) from fault
    return Bundle(manifest, work, plain.get(contents.RESULT), held)


def _require_whole(manifest: Manifest, work: Any, held: Mapping[str, bytes]) -> None:
    """Go on only if the task finds all that it reads, which are then names of no other files."""
    _TASKS[manifest.task].payload.model_validate(work)
    missing = [named for named in artifacts_of(manifest.task, work) if named not in held]
    if missing:
        message = f"it lacks files, or they were changed: sha256 {', '.join(missing)[:200]}"
        raise BundleInvalid(message)


def _archive(path: Path, max_bytes: int) -> Iterator[tuple[str, bytes]]:
    left = max_bytes
    with ZipFile(path) as archive:
        entries = archive.infolist()
        _require_few(len(entries))
        for entry in entries:
            if entry.is_dir():
                continue
            with archive.open(entry) as stream:
                content = stream.read(left + 1)
            left -= len(content)
            _require_small(left, max_bytes)
            yield entry.filename, content


def _folder(path: Path, max_bytes: int) -> Iterator[tuple[str, bytes]]:
    left = max_bytes
    files = [file for file in path.rglob("*") if file.is_file() and not file.is_symlink()]
    _require_few(len(files))
    for file in files:
        with file.open("rb") as stream:
            content = stream.read(left + 1)
        left -= len(content)
        _require_small(left, max_bytes)
        yield file.relative_to(path).as_posix(), content


def _require_few(count: int) -> None:
    if count > MAX_ENTRIES:
        message = f"it has {count} entries; at most {MAX_ENTRIES} are read"
        raise BundleInvalid(message)


def _require_small(left: int, max_bytes: int) -> None:
    if left < 0:
        message = f"its contents are larger than {max_bytes} bytes"
        raise BundleInvalid(message)
