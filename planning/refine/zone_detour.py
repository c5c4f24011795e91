"""ZoneDetour: initial guesses around speed zones, which are boxes to keep out of.

The cost of a zone has no gradient in its middle, and the gradient at one face contains nothing of
the others. So detours are tried as well: the zones become path constraints, and a curve through
them is moved over one face after another.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
from jaxtyping import Float64

from planning.domain.arrays import Array
from planning.domain.request.deadline import Deadline
from planning.domain.request.motion_limits import SpeedZone
from planning.refine.constraints.load import difference_quotients
from planning.refine.constraints.zone_load import make_zone_constraint
from planning.refine.curves.bspline_basis import basis_weights
from planning.refine.refine_problem import RefineProblem
from planning.refine.request import RefineRequest
from planning.world.constraints.box_constraint import BoxConstraint
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import World

# Samples of the moved curve, and its distance outside a face [m].
_NUM_SAMPLES = 121
_FACE_CLEARANCE = 0.01
# Number of damped least-squares steps, and their damping [m/rad].
_NUM_STEPS, _DAMPING = 4, 0.05
# Range of s before and after a visit over which the displacement tapers off.
_TAPER_LENGTH = 0.2
# Largest remaining depth for a displacement to count, as a share of the depth before.
_MAX_REMAINING_DEPTH = 0.5
# Number of faces per zone that are tried, those of least displacement first.
_MAX_FACES = 2


@dataclass(frozen=True)
class ZoneDetour:
    """The same refinement with zones to keep out of: those that contain no end of the path.

    Attributes:
        problem: Refinement problem with these zones as path constraints.
        boxes: Constraints of these zones.
    """

    problem: RefineProblem
    boxes: tuple[BoxConstraint, ...]

    @classmethod
    def of(cls, world: World, request: RefineRequest, deadline: Deadline) -> "ZoneDetour | None":
        """Build the problem of a request, or return None if there is no such zone."""
        path, motion_limits = request.path, request.motion_limits
        ends, outside, inside = path.waypoints[[0, -1]], list[BoxConstraint](), list[SpeedZone]()
        for zone in motion_limits.speed_zones:
            box = make_zone_constraint(world, path.group, zone)
            if box.are_satisfied(ends).all():
                outside.append(box)
            else:
                inside.append(zone)
        if not outside:
            return None
        path_constraints = request.constraints or PathConstraints(path.group, (), frozenset())
        with_zones = replace(
            path_constraints, constraints=(*path_constraints.constraints, *outside)
        )
        detour_request = replace(
            request,
            constraints=with_zones.tightened(ends[0], ends[1:]),
            motion_limits=replace(motion_limits, speed_zones=tuple(inside)),
        )
        return cls(RefineProblem.of(world, detour_request, deadline), tuple(outside))

    def guesses(self, points: Float64[np.ndarray, "k nv"]) -> Iterator[Array]:
        """Yield control points of curves near one that avoid the zones it visits, if any."""
        s = np.linspace(0.0, 1.0, _NUM_SAMPLES)
        deltas = basis_weights(len(points), s).apply(points)
        visited = [box for box in self.boxes if (self._box_coordinates(box, deltas)[1] < 0).any()]
        for rank in range(_MAX_FACES):
            displaced, is_new = deltas, False
            for box in visited:
                displacements = list(islice(self._displacements(box, displaced), rank + 1))
                displaced = displacements[-1] if displacements else displaced
                is_new |= len(displacements) > rank
            if is_new:
                yield self.problem.fit_waypoints(displaced)

    def _displacements(self, box: BoxConstraint, deltas: Array) -> Iterator[Array]:
        """Yield samples moved over faces of a box, for the faces where that succeeds."""
        local, margins = self._box_coordinates(box, deltas)
        if (margins >= 0).all():
            return
        for axis, sign in _faces(local, local[margins < 0], box.half):
            displaced = self._displaced_over_face(box, deltas, axis, sign)
            remaining = self._box_coordinates(box, displaced)[1].min()
            if remaining > _MAX_REMAINING_DEPTH * margins.min():
                yield displaced

    def _displaced_over_face(
        self, box: BoxConstraint, deltas: Array, axis: int, sign: float
    ) -> Array:
        """Return samples moved over a face of a box, except for the first and the last one."""
        local, margins = self._box_coordinates(box, deltas)
        s = np.linspace(0.0, 1.0, len(deltas))
        visit = s[margins < 0]
        distance = np.maximum(np.maximum(visit[0] - s, s - visit[-1]), 0.0)
        taper = (1 + np.cos(np.pi * np.minimum(distance / _TAPER_LENGTH, 1.0))) / 2
        shortfall = box.half[axis] + _FACE_CLEARANCE - sign * local[:, axis]
        target = sign * local[:, axis] + taper * np.maximum(shortfall, 0.0)
        moved = deltas.copy()
        for _ in range(_NUM_STEPS):
            current = sign * self._box_coordinates(box, moved)[0][:, axis]
            (gradients,) = difference_quotients(
                lambda at: sign * self._box_coordinates(box, at)[0][:, axis], moved
            )
            squares = np.sum(gradients**2, axis=1) + _DAMPING**2
            moved[1:-1] += (gradients * ((target - current) / squares)[:, None])[1:-1]
        return moved

    def _box_coordinates(self, box: BoxConstraint, deltas: Array) -> tuple[Array, Array]:
        """Return positions of the origin in a box's axes, and its signed margins outside [m]."""
        qs = self.problem.chart.positions(deltas)
        return box.origins_in_box(qs), box.signed_margins(qs)


def _faces(local: Array, visited: Array, half: Array) -> list[tuple[int, float]]:
    """Return faces by axis and sign, in the order of the visit's distance to them.

    Faces of an axis along which the curve crosses the box from side to side come last.
    """
    first, last = local[[0, -1]] / half
    is_across = (np.minimum(np.abs(first), np.abs(last)) > 1) & (first * last < 0)
    faces = [
        (bool(is_across[axis]), float((half[axis] - sign * visited[:, axis]).max()), axis, sign)
        for axis in np.flatnonzero(np.isfinite(half)).tolist()
        for sign in (-1.0, 1.0)
    ]
    return [(axis, sign) for *_, axis, sign in sorted(faces)]
