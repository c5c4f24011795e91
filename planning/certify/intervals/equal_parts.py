"""Pieces of a motion cut into equal parts, each into as many as it needs."""

from typing import Any

import numpy as np
from jaxtyping import Int

type Indices = np.ndarray[Any, np.dtype[np.intp]]


def split_equally(
    counts: Int[np.ndarray, " pieces"],
) -> tuple[Int[np.ndarray, " n"], Int[np.ndarray, " n"]]:
    """Return of which piece each part is, and how many of that piece come before it.

    Args:
        counts: Into how many parts each piece is cut, at least one.
    """
    owners: Indices = np.repeat(np.arange(len(counts)), counts)
    return owners, np.arange(len(owners)) - np.repeat(np.cumsum(counts) - counts, counts)
