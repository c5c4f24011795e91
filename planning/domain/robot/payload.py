"""Payload: a rigid mass that a robot carries and the scene does not contain."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.value import Value
from planning.errors import ProblemInvalid

# Relative tolerance of the triangle inequality of principal moments, for rounding.
_INERTIA_TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class Payload(Value):
    """Rigid mass fixed to a frame F; it loads every joint that carries F.

    Attributes:
        frame: Full name of F.
        mass: [kg], positive.
        center_of_mass: In F [m], shape (3,).
        inertia: About the centre of mass, along the axes of F [kg m^2], shape (3, 3); zero for a
            point mass.
    """

    frame: str
    mass: float
    center_of_mass: Float64[np.ndarray, "3"] = field(default_factory=lambda: np.zeros(3))
    inertia: Float64[np.ndarray, "3 3"] = field(default_factory=lambda: np.zeros((3, 3)))

    @classmethod
    def from_parts(
        cls,
        frame: str,
        mass: float,
        center_of_mass: Sequence[float] = (0.0, 0.0, 0.0),
        inertia: Sequence[float] = (0.0,) * 6,
    ) -> "Payload":
        """Build a payload after checking that it is physically possible.

        Args:
            frame: Full name of the frame that it is fixed to.
            mass: [kg].
            center_of_mass: In that frame [m], 3 numbers.
            inertia: Ixx, Iyy, Izz, Ixy, Ixz, Iyz about the centre of mass [kg m^2].

        Raises:
            ProblemInvalid: A number is not finite, the mass is not positive, or the inertia is not
                physical: a principal moment is negative, or greater than the sum of the other two.
                Its `field` is that of the payload.
        """
        center = np.array(center_of_mass, dtype=np.float64)
        moments = np.array(inertia, dtype=np.float64)
        if not (np.isfinite(mass) and mass > 0):
            raise _invalid_payload("mass", f"it must be positive and finite, got {mass}")
        if center.shape != (3,) or not np.isfinite(center).all():
            raise _invalid_payload("center_of_mass", "3 finite numbers are needed")
        if moments.shape != (6,) or not np.isfinite(moments).all():
            raise _invalid_payload(
                "inertia", "6 finite numbers are needed: Ixx, Iyy, Izz, Ixy, Ixz, Iyz"
            )
        xx, yy, zz, xy, xz, yz = moments
        matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        principal: Any = np.linalg.eigvalsh(matrix)
        slack = _INERTIA_TOLERANCE * np.abs(principal).max()
        if principal[0] < -slack or principal[2] > principal[0] + principal[1] + slack:
            rule = "every principal moment must be at least 0 and at most the sum of the other two"
            raise _invalid_payload(
                "inertia", f"it is not physical: {rule}; got {principal.tolist()}"
            )
        return cls(frame, float(mass), center, matrix)


def _invalid_payload(field_name: str, message: str) -> ProblemInvalid:
    return ProblemInvalid(f"{field_name}: {message}", {"field": field_name})
