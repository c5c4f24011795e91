"""Frame checks of path constraints: boxes for a frame's origin, and cones for one of its axes."""

from dataclasses import dataclass
from typing import Any, override

import numpy as np

from planning.certify.frames.frame_derivative_bounds import direction_bounds, origin_bounds
from planning.certify.frames.frame_poses import FramePoses
from planning.certify.intervals.chord_proof import BOUND_TOLERANCE, ChordProof
from planning.certify.request import CertifyRequest
from planning.domain.arrays import Array
from planning.domain.geometry import rotation
from planning.domain.report.certificate import Check
from planning.domain.request.constraint import KeepIn, KeepOut, OrientationCone, PositionBand
from planning.domain.request.deadline import Deadline
from planning.world.drake_model import DrakeModel


def box_check(
    name: str,
    constraint: KeepIn | KeepOut | PositionBand,
    model: DrakeModel,
    request: CertifyRequest,
    deadline: Deadline,
) -> Check:
    """Return the check of the largest excess of a frame's origin over the faces of a box.

    The excess is on the forbidden side: outside of a box to stay in, inside of one to stay out of.
    The signed distance to a box is convex, and changes by no more than the point moves.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
        ModelInvalid: A joint of a kind that cannot be certified.
    """
    box = constraint.box
    X_WR = FramePoses(model, request, box.reference).at_reference()
    world_box = _Box(
        X_WR[:3, :3] @ rotation.matrix(box.pose.quaternion),
        X_WR[:3, :3] @ box.pose.position + X_WR[:3, 3],
        box.size / 2,
    )
    poses = FramePoses(model, request, constraint.frame)
    quantity_type = _BoxDepth if isinstance(constraint, KeepOut) else _BoxDistance
    bounds = origin_bounds(model, request, constraint.frame)
    point_bounds = bounds.derivatives[:, 1], bounds.errors[:, 0]
    result = ChordProof(quantity_type(poses, world_box), point_bounds, request, deadline).run(0.0)
    return Check(
        name=name,
        value=result.value,
        bound=0.0,
        unit="m",
        resolution=result.upper_bound - result.value,
        passed=result.passed,
        time=result.time,
    )


def cone_check(
    name: str,
    constraint: OrientationCone,
    model: DrakeModel,
    request: CertifyRequest,
    deadline: Deadline,
) -> Check:
    """Return the check of the largest angle between an axis of a frame and a direction.

    The bound is on the tip of the axis, a point of the unit sphere; its chords correspond to
    angles.

    Raises:
        DeadlineExceeded: Time ran out.
        Canceled: The caller canceled.
        ModelInvalid: A joint of a kind that cannot be certified.
    """
    X_WR = FramePoses(model, request, constraint.reference).at_reference()
    direction = X_WR[:3, :3] @ constraint.direction
    quantity = _AxisChord(
        FramePoses(model, request, constraint.frame),
        constraint.axis / np.linalg.norm(constraint.axis),
        direction / np.linalg.norm(direction),
    )
    bounds = direction_bounds(model, request, constraint.frame)
    point_bounds = bounds.derivatives[:, 1], bounds.errors[:, 0]
    # The tolerance is an angle: near half a turn its chord changes less.
    max_angle = constraint.tolerance + BOUND_TOLERANCE
    bound = 2 * np.sin(max_angle / 2) - BOUND_TOLERANCE if max_angle < np.pi else np.inf
    result = ChordProof(quantity, point_bounds, request, deadline).run(bound)
    value, upper_bound = _angle(result.value), _angle(result.upper_bound)
    return Check(
        name=name,
        value=value,
        bound=constraint.tolerance,
        unit="rad",
        resolution=upper_bound - value,
        passed=result.passed,
        time=result.time,
    )


@dataclass(frozen=True)
class _Box:
    """A box B in world, with its half sizes [m]."""

    R_WB: Array
    p_wb: Array
    half_size: Array

    def signed_distances(self, points: Array) -> tuple[Array, Array]:
        """Return signed distances, shape (n,), and a subgradient of each in world, shape (n, 3)."""
        local = (points - self.p_wb) @ self.R_WB
        excess = np.abs(local) - self.half_size
        outside = np.maximum(excess, 0.0)
        lengths = np.linalg.norm(outside, axis=1)
        is_outside = lengths > 0
        nearest = np.eye(3)[np.argmax(excess, axis=1)]
        normals = np.where(
            is_outside[:, None], outside / np.where(is_outside, lengths, 1.0)[:, None], nearest
        ) * np.where(local < 0, -1.0, 1.0)
        return np.where(is_outside, lengths, excess.max(axis=1)), normals @ self.R_WB.T


@dataclass(frozen=True)
class _BoxDistance:
    """Signed distance of a frame's origin from a box, negative inside [m]."""

    poses: FramePoses
    box: _Box

    def points(self, pieces: Any, local: Array, deadline: Deadline) -> Array:
        return self.poses.at(pieces, local, deadline)[:, :3, 3]

    def values(self, points: Array) -> Array:
        return self.box.signed_distances(points)[0]

    def chord_bounds(self, begin: Array, end: Array) -> Array:
        """Return the larger end value: a convex function on a chord is largest at an end."""
        return np.maximum(self.values(begin), self.values(end))


@dataclass(frozen=True)
class _BoxDepth(_BoxDistance):
    """Depth of a frame's origin inside a box, negative outside [m]."""

    @override
    def values(self, points: Array) -> Array:
        return -self.box.signed_distances(points)[0]

    @override
    def chord_bounds(self, begin: Array, end: Array) -> Array:
        """Return bounds by tangent planes: a convex function is nowhere below them."""
        lower_bounds: list[Array] = []
        for here, there in ((begin, end), (end, begin)):
            distances, gradients = self.box.signed_distances(here)
            along = np.einsum("ni,ni->n", gradients, there - here)
            lower_bounds.append(distances + np.minimum(along, 0.0))
        return -np.maximum(*lower_bounds)


@dataclass(frozen=True)
class _AxisChord:
    """Chord length between the unit vectors of a frame's axis and of a direction."""

    poses: FramePoses
    axis: Array
    direction: Array

    def points(self, pieces: Any, local: Array, deadline: Deadline) -> Array:
        return self.poses.at(pieces, local, deadline)[:, :3, :3] @ self.axis

    def values(self, points: Array) -> Array:
        return np.linalg.norm(points - self.direction, axis=1)

    def chord_bounds(self, begin: Array, end: Array) -> Array:
        """Return the larger end value: a convex function on a chord is largest at an end."""
        return np.maximum(self.values(begin), self.values(end))


def _angle(chord: float) -> float:
    """Return the angle between two unit vectors at a given chord length [rad]."""
    return 2 * float(np.arcsin(min(chord / 2, 1.0)))
