"""Versions of everything that the numbers of a plan depend on."""

import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version

_DISTRIBUTIONS = ("wayproof", "drake", "ompl", "toppra", "ruckig", "numpy")


@cache
def versions() -> dict[str, str]:
    """Return versions by name; nothing is imported to find them."""
    return {"python": platform.python_version(), **{name: _of(name) for name in _DISTRIBUTIONS}}


def _of(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "unknown"  # run from a checkout that was never installed
