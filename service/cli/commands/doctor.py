"""wayproof doctor: what of this machine a server would stumble over."""

import os
import shutil
import socket
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import typer

from planning import kernel_name
from service.cli.exit_codes import ExitCode
from service.cli.options import AsJson
from service.cli.output import console, print_json
from service.cli.serve import settings_of
from service.cli.variables import sentence_of, unknown_variables
from service.settings import Settings
from service.versions import versions

_LEAST_FREE = 2**30
_LEAST_FILES = 1024


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at.

    Attributes:
        name: Of it.
        level: ok, warning (slower, or for later) or fault (a server does not work with it).
        detail: What was found.
    """

    name: str
    level: str
    detail: str


def doctor(*, as_json: AsJson = False) -> None:
    """Look at what a server needs: packages, the kernel, settings, folder, port, disk, files."""
    settings = settings_of({})
    found = list(findings(settings))
    if as_json:
        print_json([asdict(one) for one in found])
    else:
        for one in found:
            console.print(f"{one.level:<8} {one.name}: {one.detail}", markup=False, soft_wrap=True)
    if any(one.level == "fault" for one in found):
        raise typer.Exit(ExitCode.NO_RESULT)


def findings(settings: Settings) -> Iterator[Finding]:
    """Yield what there is to say of this machine."""
    yield from _packages()
    yield _kernel()
    for variable, nearest in unknown_variables(os.environ).items():
        yield Finding("settings", "warning", sentence_of(variable, nearest))
    yield _folder(settings.data_dir)
    yield _disk(settings.data_dir)
    yield _port(settings)
    yield _files()


def _packages() -> Iterator[Finding]:
    known = versions()
    missing = [name for name, version in known.items() if version == "unknown"]
    told = ", ".join(f"{name} {version}" for name, version in known.items())
    yield Finding("packages", "fault" if missing else "ok", told)


def _kernel() -> Finding:
    name = kernel_name()
    if name != "none":
        return Finding("kernel", "ok", name)
    return Finding("kernel", "warning", "not built (needs a C++20 compiler): plans take longer")


def _folder(folder: Path) -> Finding:
    parent = _existing(folder)
    try:
        with tempfile.TemporaryFile(dir=parent):
            return Finding("data folder", "ok", f"{folder} can be written")
    except OSError as fault:
        return Finding("data folder", "fault", f"{folder}: {fault.strerror or fault}")


def _disk(folder: Path) -> Finding:
    free = shutil.disk_usage(_existing(folder)).free
    level = "ok" if free >= _LEAST_FREE else "warning"
    return Finding("disk", level, f"{free / 2**30:.1f} GiB free")


def _port(settings: Settings) -> Finding:
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    where = f"{settings.host}, port {settings.port}"
    with socket.socket(family, socket.SOCK_STREAM) as bound:
        bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            bound.bind((settings.host, settings.port))
        except OSError as fault:
            return Finding("port", "fault", f"{where}: {fault.strerror or fault}")
    return Finding("port", "ok", f"{where} is free")


def _files() -> Finding:
    if sys.platform == "win32":
        return Finding("open files", "fault", "Windows is not supported")
    import resource  # noqa: PLC0415  (not on Windows)

    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    level = "ok" if hard == resource.RLIM_INFINITY or hard >= _LEAST_FILES else "warning"
    return Finding("open files", level, f"at most {hard}")


def _existing(folder: Path) -> Path:
    """Return the folder, or what there is of the way to it."""
    absolute = folder.resolve()
    return next(one for one in (absolute, *absolute.parents) if one.exists())
