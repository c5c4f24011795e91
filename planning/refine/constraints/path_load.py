"""PathLoad: the load ratios of all motions along one curve, at instants of it.

With b = (ds/dt)^2 and u = d2s/dt2 a motion has v = r' sqrt(b) and vdot = r'' b + r' u. Torques and
accelerations are linear in b and u, speeds in sqrt(b): what they are multiplied by depends on the
curve alone, and is computed once for all motions.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Indices


@dataclass(frozen=True)
class PathLoad:
    """Load ratios at m instants: rest + by_u u + by_b b + by_root sqrt(b).

    Attributes:
        rows: Coefficients c_u and c_b of rows c_u u + c_b b <= 1 that imply the limits, shape
            (m, k) each.
        static_load: Static load ratios, at rest, shape (m, j); no columns if the load has none.
        by_root: Ratios of vectors per sqrt(b), shape (m, balls, dims); None for none.
        by_u: The same per u.
        by_b: The same per b.
        rest: The same of the vectors at rest.
    """

    rows: tuple[Float64[np.ndarray, "m k"], Float64[np.ndarray, "m k"]]
    static_load: Float64[np.ndarray, "m j"]
    by_root: Float64[np.ndarray, "m balls dims"] | None = None
    by_u: Float64[np.ndarray, "m balls dims"] | None = None
    by_b: Float64[np.ndarray, "m balls dims"] | None = None
    rest: Float64[np.ndarray, "m balls dims"] | None = None

    @property
    def depends_on_u(self) -> bool:
        """Whether the ratios depend on u, so that both sides of a grid point differ."""
        return self.by_u is not None

    def ratios(
        self, instants: Indices, b: Float64[np.ndarray, " n"], u: Float64[np.ndarray, " n"]
    ) -> Float64[np.ndarray, "n balls dims"]:
        """Return the load ratios of a motion at some of the instants."""
        parts = ((self.by_root, np.sqrt(b)), (self.by_u, u), (self.by_b, b))
        terms = [part[instants] * x[:, None, None] for part, x in parts if part is not None]
        if self.rest is not None:
            terms.append(self.rest[instants])
        return sum(terms[1:], terms[0])
