"""Boxes and cones: where the origin of a frame is, and where one of its axes points."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from planning.certify.frame_watch import FrameWatch
from planning.certify.interval_proof import Sight, bounded
from planning.certify.request import CertifyRequest
from planning.certify.segments import Segment
from planning.domain import rotation
from planning.domain.certificate import Check
from planning.domain.constraint import KeepIn, KeepOut, OrientationCone, PositionBand
from planning.domain.deadline import Deadline
from planning.world.drake_model import DrakeModel

type Array = np.ndarray[Any, np.dtype[np.float64]]


def box_check(
    name: str,
    constraint: KeepIn | KeepOut | PositionBand,
    model: DrakeModel,
    request: CertifyRequest,
    deadline: Deadline,
) -> Check:
    """Return how far the origin of a frame goes beyond the faces of a box, on the wrong side.

    The distance to a convex set, and the depth in it, change by no more than the point moves.
    """
    box = constraint.box
    reference = FrameWatch(model, request, box.reference)
    turn = reference.rotation @ rotation.matrix(box.pose.quaternion)
    middle = reference.rotation @ box.pose.position + reference.origin
    watch = FrameWatch(model, request, constraint.frame)
    sign = -1.0 if isinstance(constraint, KeepOut) else 1.0
    quantity = _Excess(watch, turn, middle, box.size / 2, sign)
    return _check(name, quantity, 0.0, "m", request, deadline)


def cone_check(
    name: str,
    constraint: OrientationCone,
    model: DrakeModel,
    request: CertifyRequest,
    deadline: Deadline,
) -> Check:
    """Return the largest angle between an axis of a frame and a direction.

    It changes by no more than the frame turns.
    """
    direction = FrameWatch(model, request, constraint.reference).rotation @ constraint.direction
    watch = FrameWatch(model, request, constraint.frame)
    quantity = _Angle(
        watch,
        constraint.axis / np.linalg.norm(constraint.axis),
        direction / np.linalg.norm(direction),
    )
    return _check(name, quantity, constraint.tolerance, "rad", request, deadline)


@dataclass(frozen=True)
class _Excess:
    """How far a point is beyond a box, negative within it; times a sign."""

    watch: FrameWatch
    R_WB: Array
    p_wb: Array
    half: Array
    sign: float

    def look(self, segment: Segment) -> Sight:
        self.watch.go_to(segment.center)
        beyond = np.abs((self.watch.origin - self.p_wb) @ self.R_WB) - self.half
        deepest = float(beyond.max())
        outside = float(np.linalg.norm(np.maximum(beyond, 0.0)))
        value = self.sign * (outside if deepest > 0 else deepest)
        return Sight(value, value + self.watch.moved(segment))


@dataclass(frozen=True)
class _Angle:
    """The angle between an axis of a frame and a direction in world."""

    watch: FrameWatch
    axis: Array
    direction: Array

    def look(self, segment: Segment) -> Sight:
        self.watch.go_to(segment.center)
        axis = self.watch.rotation @ self.axis
        # The half angle from both chords: exact to rounding for small and large angles alike.
        chords = np.linalg.norm(axis - self.direction), np.linalg.norm(axis + self.direction)
        value = 2 * float(np.arctan2(*chords))
        return Sight(value, value + self.watch.turned(segment))


def _check(
    name: str,
    quantity: _Excess | _Angle,
    bound: float,
    unit: str,
    request: CertifyRequest,
    deadline: Deadline,
) -> Check:
    found = bounded(quantity, bound, request, deadline)
    return Check(
        name=name,
        value=found.value,
        bound=bound,
        unit=unit,
        resolution=found.top - found.value,
        passed=found.passed,
        time=found.time,
    )
