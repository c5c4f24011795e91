"""Equal split: pieces of a motion, each cut into a number of equal parts."""

import numpy as np
from jaxtyping import Int


def split_equally(
    counts: Int[np.ndarray, " pieces"],
) -> tuple[Int[np.ndarray, " n"], Int[np.ndarray, " n"]]:
    """Return the piece of each part, and the index of the part within its piece.

    Args:
        counts: Number of parts of each piece, at least one.
    """
    owners = np.repeat(np.arange(len(counts)), counts)
    return owners, np.arange(len(owners)) - np.repeat(np.cumsum(counts) - counts, counts)
