"""Versions of everything that the numbers of a plan depend on."""

import platform
import re
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

_DISTRIBUTIONS = ("wayproof", "drake", "ompl", "toppra", "ruckig", "numpy")
_CPU = Path("/proc/cpuinfo")
_INSTRUCTIONS = ("avx2", "fma", "avx512f", "asimd", "sve")


@cache
def versions() -> dict[str, str]:
    """Return versions by name; nothing is imported to find them."""
    return {"python": platform.python_version(), **{name: _of(name) for name in _DISTRIBUTIONS}}


@cache
def processor() -> str:
    """Return the kind of processor: on another one, sums may come in another order."""
    text = _CPU.read_text(encoding="utf-8", errors="replace") if _CPU.exists() else ""
    model = re.search(r"^model name\s*: (.*)$", text, re.MULTILINE)
    flags = re.search(r"^(?:flags|Features)\s*: (.*)$", text, re.MULTILINE)
    has = flags[1].split() if flags else []
    instructions = (name for name in _INSTRUCTIONS if name in has)
    return " ".join([platform.machine(), *([model[1].strip()] if model else []), *instructions])


def _of(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "unknown"  # run from a checkout that was never installed
