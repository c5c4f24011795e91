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

from planning.domain.request.deadline import Deadline
from planning.domain.request.motion_limits import SpeedZone
from planning.refine.constraints.load import difference_quotients
from planning.refine.constraints.zone_load import box_of
from planning.refine.curves.bspline_basis import weights_at
from planning.refine.refine_problem import RefineProblem
from planning.refine.request import RefineRequest
from planning.world.constraints.box_constraint import BoxConstraint
from planning.world.constraints.path_constraints import PathConstraints
from planning.world.world import Array, World

# Samples of the moved curve, and its distance outside a face [m].
_NUM_SAMPLES = 121
_OVER = 0.01
# Number of damped least-squares steps, and their damping [m/rad].
_STEPS, _DAMPING = 4, 0.05
# Range of s before and after a visit over which the displacement tapers off.
_TAPER = 0.2
# Largest remaining depth for a displacement to count, as a share of the depth before.
_REACHED = 0.5
# Number of faces per zone that are tried, those of least displacement first.
_MOST_FACES = 2


@dataclass(frozen=True)
class ZoneDetour:
    """The same refinement with zones to keep out of: those that contain no end of the path.

    Attributes:
        task: Refinement problem with these zones as path constraints.
        boxes: Constraints of these zones.
    """

    task: RefineProblem
    boxes: tuple[BoxConstraint, ...]

    @classmethod
    def of(cls, world: World, request: RefineRequest, share: Deadline) -> "ZoneDetour | None":
        """Build the problem of a request, or return None if there is no such zone."""
        path, others = request.path, request.others
        ends, outside, inside = path.waypoints[[0, -1]], list[BoxConstraint](), list[SpeedZone]()
        for zone in others.speed_zones:
            box = box_of(world, path.group, zone)
            if box.are_kept(ends).all():
                outside.append(box)
            else:
                inside.append(zone)
        if not outside:
            return None
        known = request.rules or PathConstraints(path.group, (), frozenset())
        rules = replace(known, rules=(*known.rules, *outside))
        changed = replace(
            request,
            rules=rules.leaving_room(ends[0], ends[1:]),
            others=replace(others, speed_zones=tuple(inside)),
        )
        return cls(RefineProblem.of(world, changed, share), tuple(outside))

    def guesses(self, points: Float64[np.ndarray, "k nv"]) -> Iterator[Array]:
        """Yield control points of curves near one that avoid the zones it visits, if any."""
        s = np.linspace(0.0, 1.0, _NUM_SAMPLES)
        deltas = weights_at(len(points), s).of(points)
        visited = [box for box in self.boxes if (self._local(box, deltas)[1] < 0).any()]
        for rank in range(_MOST_FACES):
            lifted, is_new = deltas, False
            for box in visited:
                ways = list(islice(self._ways(box, lifted), rank + 1))
                lifted = ways[-1] if ways else lifted
                is_new |= len(ways) > rank
            if is_new:
                yield self.task.near(lifted)

    def _ways(self, box: BoxConstraint, deltas: Array) -> Iterator[Array]:
        """Yield samples moved over faces of a box, for the faces where that succeeds."""
        local, out = self._local(box, deltas)
        if (out >= 0).all():
            return
        for axis, sign in _faces(local, local[out < 0], box.half):
            lifted = self._lifted(box, deltas, axis, sign)
            if self._local(box, lifted)[1].min() > _REACHED * out.min():
                yield lifted

    def _lifted(self, box: BoxConstraint, deltas: Array, axis: int, sign: float) -> Array:
        """Return samples moved over a face of a box, except for the first and the last one."""
        local, out = self._local(box, deltas)
        s = np.linspace(0.0, 1.0, len(deltas))
        visit = s[out < 0]
        away = np.maximum(np.maximum(visit[0] - s, s - visit[-1]), 0.0)
        share = (1 + np.cos(np.pi * np.minimum(away / _TAPER, 1.0))) / 2
        lacking = box.half[axis] + _OVER - sign * local[:, axis]
        goal = sign * local[:, axis] + share * np.maximum(lacking, 0.0)
        moved = deltas.copy()
        for _ in range(_STEPS):
            now = sign * self._local(box, moved)[0][:, axis]
            (slopes,) = difference_quotients(
                lambda at: sign * self._local(box, at)[0][:, axis], moved
            )
            squares = np.sum(slopes**2, axis=1) + _DAMPING**2
            moved[1:-1] += (slopes * ((goal - now) / squares)[:, None])[1:-1]
        return moved

    def _local(self, box: BoxConstraint, deltas: Array) -> tuple[Array, Array]:
        """Return positions of the origin in a box's axes, and its signed margin outside it [m]."""
        qs = self.task.chart.positions(deltas)
        return box.local(qs), box.spares(qs)


def _faces(local: Array, visited: Array, half: Array) -> list[tuple[int, float]]:
    """Return faces by axis and sign, in the order of the visit's distance to them.

    Faces of an axis along which the curve crosses the box from side to side come last.
    """
    first, last = local[[0, -1]] / half
    is_across = (np.minimum(np.abs(first), np.abs(last)) > 1) & (first * last < 0)
    found = [
        (bool(is_across[axis]), float((half[axis] - sign * visited[:, axis]).max()), axis, sign)
        for axis in np.flatnonzero(np.isfinite(half)).tolist()
        for sign in (-1.0, 1.0)
    ]
    return [(axis, sign) for *_, axis, sign in sorted(found)]
