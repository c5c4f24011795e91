"""ArmBranch of a six-joint arm: shoulder, elbow and wrist signs (the IK solution's branch).

Number the joint axes 1 to 6, with unit direction z_i through p_i. Take an arm whose axes 2 and 3
are parallel, and

- a spherical wrist (axes 4, 5, 6 meet in a point P; C = P), as PUMA-like arms have, or
- axes 4 parallel to 2 and 3, and axes 5 and 6 that meet in a point P (C is any point of axis 4),
  as Universal Robots' arms have.

Then the determinant of the tool's Jacobian is, up to sign, the product of three numbers:

    shoulder = (z_1 x (P - p_1)) . z_2           P leaves the plane of axis 1 and z_2
    elbow    = ((p_3 - p_2) x (C - p_3)) . z_2   the arm is not stretched
    wrist    = (z_4 x z_5) . z_6                 the wrist does not lose an axis

For the spherical wrist write the twists about P: the last three are pure rotations, so the
determinant is that of the velocities of P, times the wrist's; columns 2 and 3 are orthogonal to
z_2, so they give the elbow factor, and column 1 contributes its component along z_2. For the other
kind axes 2, 3, 4 span the planar motions orthogonal to z_2, the elbow factor; modulo those,
axes 5 and 6 only turn and axis 1 alone moves P along z_2. (Compare Pieper, "The Kinematics of
Manipulators under Computer Control", 1968, and Hawkins, "Analytic Inverse Kinematics for the
Universal Robots UR-5/UR-10 Arms", 2013, whose eight solutions these three signs tell apart.)

Each sign changes only where that factor is zero, which is a singularity. A sign distinguishes the
two ways in which an arm bends; it is not tied to the names left/right, up/down or flip.
"""

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.goals.configuration_quality import ArmBranch

# Tolerance within which axes are parallel, or meet [rad, m].
_TOLERANCE = 1e-4
# Factors whose magnitude is below this count as singular, with sign 0 [m, m^2, 1].
_SINGULAR_BELOW = 1e-9


def branch_of(
    directions: Float64[np.ndarray, "6 3"], points: Float64[np.ndarray, "6 3"]
) -> ArmBranch | None:
    """Return the branch of an arm; None if its axes are of neither kind (see module docstring).

    Args:
        directions: z_i of the joints from base to tool, unit vectors in world.
        points: A point on each axis, in world [m].
    """
    z, p = directions, points
    if not _are_parallel(z[1], z[2]):
        return None
    wrist_point = _intersection(z[4], p[4], z[5], p[5])
    if wrist_point is None:
        return None
    point_45 = _intersection(z[3], p[3], z[4], p[4])
    if point_45 is not None and np.linalg.norm(point_45 - wrist_point) < _TOLERANCE:
        center = wrist_point
    elif _are_parallel(z[2], z[3]):
        center = p[3]
    else:
        return None
    return ArmBranch(
        shoulder=_sign(np.cross(z[0], wrist_point - p[0]) @ z[1]),
        elbow=_sign(np.cross(p[2] - p[1], center - p[2]) @ z[1]),
        wrist=_sign(np.cross(z[3], z[4]) @ z[5]),
    )


def _are_parallel(a: Array, b: Array) -> bool:
    return bool(np.linalg.norm(np.cross(a, b)) < _TOLERANCE)


def _intersection(z_a: Array, p_a: Array, z_b: Array, p_b: Array) -> Array | None:
    """Return the intersection point of two lines; None if they are parallel or skew."""
    normal = np.cross(z_a, z_b)
    square = float(normal @ normal)
    gap = p_b - p_a
    if square < _TOLERANCE**2 or abs(float(gap @ normal)) / np.sqrt(square) > _TOLERANCE:
        return None
    return p_a + z_a * float(np.cross(gap, z_b) @ normal) / square


def _sign(factor: float) -> int:
    return 0 if abs(factor) < _SINGULAR_BELOW else int(np.sign(factor))
