"""Frame checks of path constraints: boxes for a frame's origin, and cones for one of its axes."""

from dataclasses import dataclass
from typing import Any, override

import numpy as np

from planning.certify.frames.frame_chain import (
    derivative_bounds,
    direction_bounds,
    direction_errors,
    origin_errors,
)
from planning.certify.frames.frame_poses import FramePoses
from planning.certify.intervals.chord_proof import SLACK, ChordProof
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
    placed = _Box(
        X_WR[:3, :3] @ rotation.matrix(box.pose.quaternion),
        X_WR[:3, :3] @ box.pose.position + X_WR[:3, 3],
        box.size / 2,
    )
    poses = FramePoses(model, request, constraint.frame)
    kind = _Depth if isinstance(constraint, KeepOut) else _BoxDistance
    moving = model, request, constraint.frame
    bends = derivative_bounds(*moving)[:, 1], origin_errors(*moving)[:, 0]
    found = ChordProof(kind(poses, placed), bends, request, deadline).run(0.0)
    return Check(
        name=name,
        value=found.value,
        bound=0.0,
        unit="m",
        resolution=found.top - found.value,
        passed=found.passed,
        time=found.time,
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
    quantity = _Chord(
        FramePoses(model, request, constraint.frame),
        constraint.axis / np.linalg.norm(constraint.axis),
        direction / np.linalg.norm(direction),
    )
    moving = model, request, constraint.frame
    bends = direction_bounds(*moving)[:, 1], direction_errors(*moving)
    # The tolerance is an angle: near half a turn its chord changes less.
    largest = constraint.tolerance + SLACK
    bound = 2 * np.sin(largest / 2) - SLACK if largest < np.pi else np.inf
    found = ChordProof(quantity, bends, request, deadline).run(bound)
    value, top = _angle(found.value), _angle(found.top)
    return Check(
        name=name,
        value=value,
        bound=constraint.tolerance,
        unit="rad",
        resolution=top - value,
        passed=found.passed,
        time=found.time,
    )


@dataclass(frozen=True)
class _Box:
    """A box B in world, with its half sizes [m]."""

    R_WB: Array
    p_wb: Array
    half: Array

    def signed_distances(self, points: Array) -> tuple[Array, Array]:
        """Return signed distances, shape (n,), and a subgradient of each in world, shape (n, 3)."""
        local = (points - self.p_wb) @ self.R_WB
        beyond = np.abs(local) - self.half
        out = np.maximum(beyond, 0.0)
        lengths = np.linalg.norm(out, axis=1)
        is_out = lengths > 0
        nearest = np.eye(3)[np.argmax(beyond, axis=1)]
        normals = np.where(
            is_out[:, None], out / np.where(is_out, lengths, 1.0)[:, None], nearest
        ) * np.where(local < 0, -1.0, 1.0)
        return np.where(is_out, lengths, beyond.max(axis=1)), normals @ self.R_WB.T


@dataclass(frozen=True)
class _BoxDistance:
    """Signed distance of a frame's origin from a box, negative inside [m]."""

    poses: FramePoses
    box: _Box

    def points(self, pieces: Any, local: Array, deadline: Deadline) -> Array:
        return self.poses.at(pieces, local, deadline)[:, :3, 3]

    def values(self, points: Array) -> Array:
        return self.box.signed_distances(points)[0]

    def on_chords(self, begin: Array, end: Array) -> Array:
        """Return the larger end value: a convex function on a chord is largest at an end."""
        return np.maximum(self.values(begin), self.values(end))


@dataclass(frozen=True)
class _Depth(_BoxDistance):
    """Depth of a frame's origin inside a box, negative outside [m]."""

    @override
    def values(self, points: Array) -> Array:
        return -self.box.signed_distances(points)[0]

    @override
    def on_chords(self, begin: Array, end: Array) -> Array:
        """Return bounds by tangent planes: a convex function is nowhere below them."""
        lowest: list[Array] = []
        for here, there in ((begin, end), (end, begin)):
            distances, slopes = self.box.signed_distances(here)
            along = np.einsum("ni,ni->n", slopes, there - here)
            lowest.append(distances + np.minimum(along, 0.0))
        return -np.maximum(*lowest)


@dataclass(frozen=True)
class _Chord:
    """Chord length between the unit vectors of a frame's axis and of a direction."""

    poses: FramePoses
    axis: Array
    direction: Array

    def points(self, pieces: Any, local: Array, deadline: Deadline) -> Array:
        return self.poses.at(pieces, local, deadline)[:, :3, :3] @ self.axis

    def values(self, points: Array) -> Array:
        return np.linalg.norm(points - self.direction, axis=1)

    def on_chords(self, begin: Array, end: Array) -> Array:
        """Return the larger end value: a convex function on a chord is largest at an end."""
        return np.maximum(self.values(begin), self.values(end))


def _angle(chord: float) -> float:
    """Return the angle between two unit vectors at a given chord length [rad]."""
    return 2 * float(np.arcsin(min(chord / 2, 1.0)))
