"""JointLock: a search over some joints of a group while the others stay where they are."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.curves.path import JointPath
from planning.domain.request.deadline import Deadline
from planning.domain.request.options import SearchOptions
from planning.domain.request.stopwatch import Stopwatch
from planning.domain.robot.joints import Joint, JointGroup, JointLimits
from planning.domain.robot.steering import steered, steering_of
from planning.errors import NoPathFound
from planning.search.collision_oracle import CollisionOracle
from planning.search.ompl.projected_space import Residual
from planning.search.request import SearchResult, SearchTask
from planning.search.solver import search

type Array = np.ndarray[Any, np.dtype[np.float64]]
type Indices = np.ndarray[Any, np.dtype[np.intp]]

# A goal whose locked joints are this near to the start's has them there [rad or m].
_SAME = 1e-6


def search_with_locked_joints(  # noqa: PLR0913, PLR0917  (what `search` takes, and what is locked)
    group: JointGroup,
    locked: frozenset[str],
    limits: JointLimits,
    oracle: CollisionOracle,
    task: SearchTask,
    deadline: Deadline,
    watch: Stopwatch,
) -> SearchResult:
    """Return what `search` finds if the joints named in `locked` stay as the start has them.

    Raises:
        ProblemInvalid: A number in the task makes no sense.
        UnknownName: There is no such planner, or it has no such parameter.
        NoPathFound: There is no goal or no path with these joints where they are.
        DeadlineExceeded: The time ran out.
        Canceled: The end was asked for.
    """
    if not locked:
        return search(group, limits, oracle, task, deadline, watch)
    lock = JointLock(group, locked, task.start)
    rows = np.flatnonzero(
        np.abs(task.goals[:, lock.stay_q] - task.start[lock.stay_q]).max(1) <= _SAME
    )
    if not len(rows) or not lock.free.joints:
        message = "no goal is reached with the locked joints where the start has them"
        raise NoPathFound(message, {"reason": "goals", "locked": sorted(locked)})
    clearances = task.clearances
    part = replace(
        task,
        start=task.start[lock.move_q],
        goals=task.goals[rows][:, lock.move_q],
        options=lock.options(task.options),
        residual=None if task.residual is None else LockedResidual(lock, task.residual),
        clearances=None if clearances is None else (lambda q: clearances(lock.expand(q))),
    )
    found = search(
        lock.free, lock.limits(limits), LockedJointOracle(lock, oracle), part, deadline, watch
    )
    graph = found.graph
    return replace(
        found,
        path=JointPath(group, lock.expand(found.path.waypoints)),
        goal_row=int(rows[found.goal_row]),
        graph=None if graph is None else replace(graph, vertices=lock.expand(graph.vertices)),
    )


class JointLock:
    """Which joints move, and where the others are.

    Attributes:
        free: The joints that move, as a group.
        move_q: Their coordinates in the group's q.
        move_v: And in its v.
        stay_q: The coordinates of the others in q.
    """

    def __init__(
        self, group: JointGroup, locked: frozenset[str], start: Float64[np.ndarray, " nq"]
    ) -> None:
        """Lock joints, by name, where the start, shape (nq,), has them."""
        moving = tuple(joint for joint in group.joints if joint.name not in locked)
        steering = {name: how for name, how in steering_of(group).items() if name not in locked}
        self.free = steered(
            JointGroup(group.name, moving, group.tool_frames, group.winding), steering
        )
        self._start = start
        self._nv = group.num_velocities
        self._joints, self._locked = group.joints, locked
        self.move_q, self.stay_q = self._split([j.num_positions for j in group.joints])
        self.move_v, _ = self._split([j.num_velocities for j in group.joints])

    def options(self, options: SearchOptions) -> SearchOptions:
        """Return the options without what they say of joints that do not move."""

        def moving(by_name: Mapping[str, Any]) -> dict[str, Any]:
            return {
                name: value
                for name, value in by_name.items()
                if not any(name == joint or name.startswith(f"{joint}.") for joint in self._locked)
            }

        return replace(
            options,
            weights=moving(options.weights),
            bounds=moving(options.bounds),
            spaces=moving(options.spaces),
        )

    def limits(self, limits: JointLimits) -> JointLimits:
        """Return those of the joints that move."""
        moves = [joint.name not in self._locked for joint in self._joints for _ in joint.blocks]
        rows = np.flatnonzero(moves)
        return JointLimits(
            limits.lower[self.move_q],
            limits.upper[self.move_q],
            limits.velocity[rows],
            limits.acceleration[rows],
            limits.jerk[rows],
            limits.effort[rows],
            tuple(indices for _, indices in self.free.blocks),
        )

    def expand(self, qs: Float64[np.ndarray, "*m nf"]) -> Float64[np.ndarray, "*m nq"]:
        """Return the whole group's configurations."""
        whole = np.broadcast_to(self._start, (*qs.shape[:-1], len(self._start))).copy()
        whole[..., self.move_q] = qs
        return whole

    def expand_tangents(self, v: Float64[np.ndarray, "*m nf"]) -> Float64[np.ndarray, "*m nv"]:
        """Return the whole group's displacements."""
        whole = np.zeros((*v.shape[:-1], self._nv))
        whole[..., self.move_v] = v
        return whole

    def _split(self, counts: list[int]) -> tuple[Indices, Indices]:
        """Return the coordinates of the joints that move, and of those that stay."""
        flags = np.repeat([not self._is_locked(joint) for joint in self._joints], counts)
        return np.flatnonzero(flags), np.flatnonzero(~flags)

    def _is_locked(self, joint: Joint) -> bool:
        return joint.name in self._locked


@dataclass(frozen=True)
class LockedJointOracle:
    """An oracle of the whole group, asked about the joints that move."""

    lock: JointLock
    inner: CollisionOracle

    def is_free(self, q: Float64[np.ndarray, " nq"]) -> bool:
        """Return whether the whole group is free."""
        return self.inner.is_free(self.lock.expand(q))

    def are_free(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return the same for each row."""
        return self.inner.are_free(self.lock.expand(qs))

    def is_motion_free(
        self,
        origin: Float64[np.ndarray, " nq"],
        displacement: Float64[np.ndarray, " nv"],
        resolution: float,
    ) -> bool:
        """Return whether every sample of a motion is free."""
        whole = self.lock.expand(origin), self.lock.expand_tangents(displacement)
        return self.inner.is_motion_free(*whole, resolution)

    def are_motions_free(
        self,
        origins: Float64[np.ndarray, "m nq"],
        displacements: Float64[np.ndarray, "m nv"],
        resolution: float,
    ) -> Bool[np.ndarray, " m"]:
        """Return the same for each pair of rows."""
        whole = self.lock.expand(origins), self.lock.expand_tangents(displacements)
        return self.inner.are_motions_free(*whole, resolution)


@dataclass(frozen=True)
class LockedResidual:
    """A residual of the whole group, as a function of the joints that move."""

    lock: JointLock
    inner: Residual

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return self.inner.size

    def residual(self, q: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, " size"]:
        """Return it at q."""
        return self.inner.residual(self.lock.expand(q))

    def jacobian(self, q: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, "size nv"]:
        """Return its derivative by the joints that move."""
        return self.inner.jacobian(self.lock.expand(q))[:, self.lock.move_v]
