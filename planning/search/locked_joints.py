"""JointLock: search over some joints of a group, with the others fixed at their start positions."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.arrays import Indices
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

# Largest difference between start and goal in a locked joint, for the goal to count [rad or m].
_POSITION_TOLERANCE = 1e-6


def search_with_locked_joints(  # noqa: PLR0913, PLR0917  (what `search` takes, and what is locked)
    group: JointGroup,
    locked: frozenset[str],
    limits: JointLimits,
    oracle: CollisionOracle,
    task: SearchTask,
    deadline: Deadline,
    watch: Stopwatch,
) -> SearchResult:
    """Return the result of `search` with the joints named in `locked` fixed at their start values.

    Raises:
        ProblemInvalid: A number in the task is out of range.
        UnknownName: There is no such planner, or it has no such parameter.
        NoPathFound: There is no goal or no path with the locked joints at their start positions.
        DeadlineExceeded: The time ran out.
        Canceled: The request was canceled.
    """
    if not locked:
        return search(group, limits, oracle, task, deadline, watch)
    lock = JointLock(group, locked, task.start)
    rows = np.flatnonzero(
        np.abs(task.goals[:, lock.locked_q_indices] - task.start[lock.locked_q_indices]).max(1)
        <= _POSITION_TOLERANCE
    )
    if not len(rows) or not lock.free.joints:
        message = "no goal configuration has the locked joints at their start positions"
        raise NoPathFound(message, {"reason": "goals", "locked": sorted(locked)})
    clearances = task.clearances
    free_task = replace(
        task,
        start=task.start[lock.free_q_indices],
        goals=task.goals[rows][:, lock.free_q_indices],
        options=lock.options(task.options),
        residual=None if task.residual is None else LockedResidual(lock, task.residual),
        clearances=None if clearances is None else (lambda q: clearances(lock.expand(q))),
    )
    result = search(
        lock.free, lock.limits(limits), LockedJointOracle(lock, oracle), free_task, deadline, watch
    )
    graph = result.graph
    return replace(
        result,
        path=JointPath(group, lock.expand(result.path.waypoints)),
        goal_row=int(rows[result.goal_row]),
        graph=None if graph is None else replace(graph, vertices=lock.expand(graph.vertices)),
    )


class JointLock:
    """Moving joints of a group, and the fixed positions of its locked joints.

    Attributes:
        free: The moving joints, as a group.
        free_q_indices: Indices of their coordinates in the group's q.
        free_v_indices: Indices of their coordinates in the group's v.
        locked_q_indices: Indices of the locked joints' coordinates in q.
    """

    def __init__(
        self, group: JointGroup, locked: frozenset[str], start: Float64[np.ndarray, " nq"]
    ) -> None:
        """Lock joints, by name, at their positions in the start, shape (nq,)."""
        moving = tuple(joint for joint in group.joints if joint.name not in locked)
        steering = {name: how for name, how in steering_of(group).items() if name not in locked}
        self.free = steered(
            JointGroup(group.name, moving, group.tool_frames, group.winding), steering
        )
        self._start = start
        self._nv = group.num_velocities
        self._joints, self._locked = group.joints, locked
        self.free_q_indices, self.locked_q_indices = self._split([
            j.num_positions for j in group.joints
        ])
        self.free_v_indices, _ = self._split([j.num_velocities for j in group.joints])

    def options(self, options: SearchOptions) -> SearchOptions:
        """Return the options without weights, bounds and spaces of locked joints."""

        def of_free_joints(by_name: Mapping[str, Any]) -> dict[str, Any]:
            return {
                name: value
                for name, value in by_name.items()
                if not any(name == joint or name.startswith(f"{joint}.") for joint in self._locked)
            }

        return replace(
            options,
            weights=of_free_joints(options.weights),
            bounds=of_free_joints(options.bounds),
            spaces=of_free_joints(options.spaces),
        )

    def limits(self, limits: JointLimits) -> JointLimits:
        """Return the limits of the moving joints."""
        is_free = [joint.name not in self._locked for joint in self._joints for _ in joint.blocks]
        rows = np.flatnonzero(is_free)
        return JointLimits(
            limits.lower[self.free_q_indices],
            limits.upper[self.free_q_indices],
            limits.velocity[rows],
            limits.acceleration[rows],
            limits.jerk[rows],
            limits.effort[rows],
            tuple(indices for _, indices in self.free.blocks),
        )

    def expand(self, qs: Float64[np.ndarray, "*m nf"]) -> Float64[np.ndarray, "*m nq"]:
        """Return configurations of the whole group from those of the moving joints."""
        full_q = np.broadcast_to(self._start, (*qs.shape[:-1], len(self._start))).copy()
        full_q[..., self.free_q_indices] = qs
        return full_q

    def expand_tangents(self, v: Float64[np.ndarray, "*m nf"]) -> Float64[np.ndarray, "*m nv"]:
        """Return displacements of the whole group from those of the moving joints."""
        full_v = np.zeros((*v.shape[:-1], self._nv))
        full_v[..., self.free_v_indices] = v
        return full_v

    def _split(self, counts: list[int]) -> tuple[Indices, Indices]:
        """Return the indices of the moving joints' coordinates, and of the locked ones'."""
        flags = np.repeat([not self._is_locked(joint) for joint in self._joints], counts)
        return np.flatnonzero(flags), np.flatnonzero(~flags)

    def _is_locked(self, joint: Joint) -> bool:
        return joint.name in self._locked


@dataclass(frozen=True)
class LockedJointOracle:
    """Collision oracle of the whole group, as a function of its moving joints."""

    lock: JointLock
    inner: CollisionOracle

    def is_free(self, q: Float64[np.ndarray, " nq"]) -> bool:
        """Return whether the whole group is free at q of the moving joints, shape (nq,)."""
        return self.inner.is_free(self.lock.expand(q))

    def are_free(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether the whole group is free at each row of qs, shape (m, nq)."""
        return self.inner.are_free(self.lock.expand(qs))

    def is_motion_free(
        self,
        origin: Float64[np.ndarray, " nq"],
        displacement: Float64[np.ndarray, " nv"],
        resolution: float,
    ) -> bool:
        """Return whether every sample of a motion is free."""
        full_motion = self.lock.expand(origin), self.lock.expand_tangents(displacement)
        return self.inner.is_motion_free(*full_motion, resolution)

    def are_motions_free(
        self,
        origins: Float64[np.ndarray, "m nq"],
        displacements: Float64[np.ndarray, "m nv"],
        resolution: float,
    ) -> Bool[np.ndarray, " m"]:
        """Return whether every sample of each motion is free, by pairs of rows."""
        full_motions = self.lock.expand(origins), self.lock.expand_tangents(displacements)
        return self.inner.are_motions_free(*full_motions, resolution)


@dataclass(frozen=True)
class LockedResidual:
    """Constraint residual of the whole group, as a function of its moving joints."""

    lock: JointLock
    inner: Residual

    @property
    def size(self) -> int:
        """Number of components."""
        return self.inner.size

    def residual(self, q: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, " size"]:
        """Return the residual at q."""
        return self.inner.residual(self.lock.expand(q))

    def jacobian(self, q: Float64[np.ndarray, " nq"]) -> Float64[np.ndarray, "size nv"]:
        """Return its derivative with respect to v of the moving joints."""
        return self.inner.jacobian(self.lock.expand(q))[:, self.lock.free_v_indices]
