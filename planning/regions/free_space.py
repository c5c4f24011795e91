"""FreeSpace: interface of the collision checker that region growth uses."""

from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float64


@runtime_checkable
class FreeSpace(Protocol):
    """Collision checker of a joint group, by batches."""

    def are_free(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether each configuration (row) is free: all pairs keep their margins."""
        ...

    def are_motions_free(
        self,
        origins: Float64[np.ndarray, "m nq"],
        displacements: Float64[np.ndarray, "m nv"],
        resolution: float,
    ) -> Bool[np.ndarray, " m"]:
        """Return whether samples of each straight motion are free.

        Args:
            origins: Start of each motion.
            displacements: Tangent displacement of each motion.
            resolution: Largest distance between samples [rad or m].
        """
        ...
