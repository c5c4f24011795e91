"""Arrays to JSON: plain lists, null for what is infinite."""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np


def listed(array: np.ndarray[Any, Any]) -> list[Any]:
    """Return an array as nested lists of floats."""
    nested: list[Any] = np.asarray(array, dtype=np.float64).tolist()
    return nested


def finite(number: float) -> float | None:
    """Return the number, or None if JSON cannot hold it."""
    return float(number) if math.isfinite(number) else None


def bounds(numbers: Iterable[float]) -> list[float | None]:
    """Return numbers with None for those that bound nothing."""
    return [finite(number) for number in numbers]
