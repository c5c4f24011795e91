"""FrameWatch: where a frame is, and how far it can move and turn within a segment."""

from typing import Any

import numpy as np

from planning.certify.collision_shapes import CollisionShapes
from planning.certify.motion_bounds import MotionBounds
from planning.certify.placed_shapes import PlacedShapes
from planning.certify.request import CertifyRequest
from planning.certify.segments import Segment
from planning.world.drake_model import DrakeModel

type Array = np.ndarray[Any, np.dtype[np.float64]]


class FrameWatch:
    """One frame of a model, in a context of its own.

    Attributes:
        rotation: R_WF, where it is now, shape (3, 3).
        origin: p_WF [m], shape (3,).
    """

    def __init__(self, model: DrakeModel, request: CertifyRequest, name: str) -> None:
        """Put the group at the request's reference.

        Raises:
            ModelInvalid: A joint of a kind that cannot be certified.
        """
        self._model, self._group, self._state = model, request.group, request.state
        self._frame = model.frames[name]
        self._body = int(self._frame.body().index())
        fixed = self._frame.GetFixedPoseInBodyFrame()
        # To the bounds of motion the origin is a shape like any other, of no size.
        shapes = _point(self._body, np.array(fixed.translation()))
        self._bounds = MotionBounds(model, request.group, shapes)
        self._placed = PlacedShapes(model, shapes, self._bounds)
        self._context = model.plant.CreateDefaultContext()
        self.rotation, self.origin = np.eye(3), np.zeros(3)
        self.go_to(request.reference)

    def go_to(self, q: Array) -> None:
        """Put the group at q, shape (nq,), and all else where it is."""
        full = self._model.embed(self._group, q, self._state)
        self._model.plant.SetPositions(self._context, full)
        self._placed.place(self._context)
        pose = self._frame.CalcPoseInWorld(self._context)
        self.rotation = np.array(pose.rotation().matrix())
        self.origin = np.array(pose.translation())

    def moved(self, segment: Segment) -> float:
        """Return how far the origin can be within a segment from where it is at its centre [m].

        The centre is where the group must be.
        """
        placed = self._placed
        reaches = self._bounds.reaches(
            placed.rotations, placed.positions, segment.turn, segment.shift
        )
        return float(reaches.sum())

    def turned(self, segment: Segment) -> float:
        """Return how far the frame can turn within a segment [rad]."""
        return self._bounds.rotation(self._body, segment.turn, segment.shift)


def _point(body: int, p_bf: Array) -> CollisionShapes:
    nothing = np.zeros((1, 3))
    return CollisionShapes(
        rows={},
        bodies=np.array([body], dtype=np.intp),
        R_BG=np.eye(3)[None],
        p_bg=p_bf[None],
        vertices=np.zeros((1, 1, 3)),
        axes=nothing,
        balls=np.zeros(1),
        centers=p_bf[None],
        radii=np.zeros(1),
        is_half_space=np.zeros(1, dtype=bool),
    )
