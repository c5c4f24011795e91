"""Equal parts: pieces of a motion, each cut into a number of equal parts."""

from typing import Any

import numpy as np
from jaxtyping import Int

type Indices = np.ndarray[Any, np.dtype[np.intp]]


def split_equally(
    counts: Int[np.ndarray, " pieces"],
) -> tuple[Int[np.ndarray, " n"], Int[np.ndarray, " n"]]:
    """Return the piece of each part, and the index of the part within its piece.

    Args:
        counts: Number of parts of each piece, at least one.
    """
    owners: Indices = np.repeat(np.arange(len(counts)), counts)
    return owners, np.arange(len(owners)) - np.repeat(np.cumsum(counts) - counts, counts)
