"""FreeSpace: what growth asks of a world."""

from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float64


@runtime_checkable
class FreeSpace(Protocol):
    """Says what keeps its distances."""

    def are_free(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether each configuration, a row each, is free."""
        ...

    def are_motions_free(
        self,
        origins: Float64[np.ndarray, "m nq"],
        displacements: Float64[np.ndarray, "m nv"],
        resolution: float,
    ) -> Bool[np.ndarray, " m"]:
        """Return whether samples of each straight way, a pair of rows each, are free."""
        ...
