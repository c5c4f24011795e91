"""OuterPolytope: a polytope of few faces around a convex shape, and close to it."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from planning.kernel.coverings.convex_polytope import ConvexPolytope
from planning.kernel.coverings.solid import Solid

# Largest distance of its corners from the shape: a share of its width, and at least this [m].
_SHARE, _LEAST = 0.008, 3e-4
# Largest number of faces: around a hull, and around shapes without flat faces.
_MOST_FACES, _FEW_FACES = 100, 48
_CUTS_PER_LOOK = 12


@dataclass(frozen=True)
class OuterPolytope:
    """Polytope that contains a shape.

    Attributes:
        piece: Its corners.
        planes: Its faces as rows (n, d): unit outward normal n, and n . x <= d inside, shape
            (f, 4).
    """

    piece: ConvexPolytope
    planes: Float64[np.ndarray, "f 4"]

    @classmethod
    def of(cls, solid: Solid) -> "OuterPolytope":
        """Cut corners off the bounding box by tangent planes, the farthest ones first.

        All planes are moved outwards by a rounding margin: corners that lie on a plane but for
        rounding, as many do in symmetric shapes, are then below it.
        """
        low, high = solid.low - solid.rounding_margin, solid.high + solid.rounding_margin
        piece = ConvexPolytope.box(low, high)
        sides = np.eye(3)
        planes = [np.append(-n, d) for n, d in zip(sides, -low, strict=True)]
        planes += [np.append(n, d) for n, d in zip(sides, high, strict=True)]
        enough = max(_LEAST, _SHARE * solid.width)
        most = _MOST_FACES if len(solid.shape.vertices) else _FEW_FACES
        while len(planes) < most:
            tangents = solid.tangents(piece.corners)
            excess = (piece.corners * tangents[:, :3]).sum(axis=1) - tangents[:, 3]
            worst = np.argsort(-excess, kind="stable")[:_CUTS_PER_LOOK]
            bar = max(enough, 0.5 * float(excess[worst[0]]))
            if excess[worst[0]] <= enough:
                break
            for plane in tangents[worst[excess[worst] > bar]]:
                if (piece.corners @ plane[:3]).max() - plane[3] <= bar:
                    continue
                offset = float(plane[3]) + solid.rounding_margin
                planes.append(np.append(plane[:3], offset))
                piece = piece.below(plane[:3], offset, len(planes))
        return cls(piece, np.array(planes))
