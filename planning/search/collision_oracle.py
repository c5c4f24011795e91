"""CollisionOracle: validity of configurations and motions of a group, as queried by the search."""

from collections.abc import Generator
from contextlib import contextmanager
from typing import Any, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float64

from planning.domain.arrays import Array, Flags, Indices
from planning.domain.curves.motion_samples import num_steps, sample_batches, steps_of
from planning.domain.request.deadline import Deadline
from planning.domain.robot.joints import JointGroup, JointLimits
from planning.domain.robot.manifold import Manifold

# Most states in one call of the inner oracle between two checks of the deadline (or one motion).
_MAX_BATCH_STATES = 4096


@runtime_checkable
class CollisionOracle(Protocol):
    """Validity of configurations and of straight motions of a group."""

    def is_free(self, q: Float64[np.ndarray, " nq"]) -> bool:
        """Return whether the group at q, shape (nq,), keeps its required distances."""
        ...

    def are_free(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return whether each row of qs, shape (m, nq), keeps its required distances."""
        ...

    def is_motion_free(
        self,
        origin: Float64[np.ndarray, " nq"],
        displacement: Float64[np.ndarray, " nv"],
        resolution: float,
    ) -> bool:
        """Return whether every sample of a motion is free, as `motion_samples` defines them."""
        ...

    def are_motions_free(
        self,
        origins: Float64[np.ndarray, "m nq"],
        displacements: Float64[np.ndarray, "m nv"],
        resolution: float,
    ) -> Bool[np.ndarray, " m"]:
        """Return whether each motion is free, by pairs of rows, shapes (m, nq) and (m, nv)."""
        ...


@runtime_checkable
class EdgeOracle(Protocol):
    """Oracle that checks edges given as lists, which avoids creating arrays."""

    def is_edge_free(self, q0: list[float], q1: list[float], resolution: float) -> tuple[bool, int]:
        """Return whether the straight edge is free, both ends included, and its number of steps."""
        ...


class WatchedOracle:
    """Oracle that counts states, enforces limits of wrapping joints, and checks the deadline.

    The bounds of OMPL's spaces cover every other coordinate; OMPL has no bounds for an angle on a
    circle.

    Attributes:
        inner: The oracle that decides.
        num_states: Configurations queried so far; every sample of a motion counts, checked or not,
            so that the number does not depend on the implementation of the inner oracle.
    """

    def __init__(
        self, inner: CollisionOracle, group: JointGroup, limits: JointLimits, deadline: Deadline
    ) -> None:
        """Wrap the oracle `inner`, for the joints and limits of a group."""
        self.inner = inner
        self._deadline = deadline
        self._check_edge = (
            inner.is_edge_free if isinstance(inner, EdgeOracle) else self._check_edge_as_motion
        )
        self._manifold = Manifold.of(group.joints)
        self._wrapping_indices, self._lower, self._widths = _limited_wrapping_coordinates(
            group, limits
        )
        self.num_states = 0

    @contextmanager
    def with_deadline(self, deadline: Deadline) -> Generator[None]:
        """Use another deadline within the context."""
        previous, self._deadline = self._deadline, deadline
        try:
            yield
        finally:
            self._deadline = previous

    def set_deadline(self, deadline: Deadline) -> None:
        """Use another deadline from now on; inside an `with_deadline` context, up to its end."""
        self._deadline = deadline

    def check_deadline(self) -> None:
        """Raise if the search must end now.

        Raises:
            Canceled: The request was canceled.
            DeadlineExceeded: The time has run out.
        """
        self._deadline.check("search")

    def is_free(self, q: Float64[np.ndarray, " nq"]) -> bool:
        """Return whether q, shape (nq,), is admissible.

        Raises:
            Canceled: The request was canceled.
            DeadlineExceeded: The time has run out.
        """
        self._deadline.check("search")
        self.num_states += 1
        if self._wrapping_indices and not self._are_within_wrapping_limits(q[None])[0]:
            return False
        return self.inner.is_free(q)

    def are_free(self, qs: Float64[np.ndarray, "m nq"]) -> Bool[np.ndarray, " m"]:
        """Return the same for each row of qs, shape (m, nq).

        Raises:
            Canceled: The request was canceled.
            DeadlineExceeded: The time has run out.
        """
        self._deadline.check("search")
        self.num_states += len(qs)
        verdicts = self.inner.are_free(qs)
        return (
            verdicts & self._are_within_wrapping_limits(qs) if self._wrapping_indices else verdicts
        )

    def is_motion_free(
        self,
        origin: Float64[np.ndarray, " nq"],
        displacement: Float64[np.ndarray, " nv"],
        resolution: float,
    ) -> bool:
        """Return whether every sample of a motion is admissible; the origin is not one of them.

        Raises:
            Canceled: The request was canceled.
            DeadlineExceeded: The time has run out.
        """
        steps = num_steps(displacement, resolution)
        if self._wrapping_indices or steps > _MAX_BATCH_STATES:
            return bool(self.are_motions_free(origin[None], displacement[None], resolution)[0])
        self._deadline.check("search")
        self.num_states += steps
        return self.inner.is_motion_free(origin, displacement, resolution)

    def is_edge_free(self, q0: list[float], q1: list[float], resolution: float) -> bool:
        """Return whether the straight edge from q0 to q1 is admissible, both ends included.

        Only for joints that neither wrap nor float.

        Raises:
            Canceled: The request was canceled.
            DeadlineExceeded: The time has run out.
        """
        self._deadline.check("search")
        free, steps = self._check_edge(q0, q1, resolution)
        self.num_states += steps + 1
        return free

    def _check_edge_as_motion(
        self, q0: list[float], q1: list[float], resolution: float
    ) -> tuple[bool, int]:
        begin, end = np.array(q0), np.array(q1)
        steps = num_steps(end - begin, resolution)
        free = self.inner.is_free(begin) and self.inner.is_motion_free(
            begin, end - begin, resolution
        )
        return free, steps

    def are_motions_free(
        self,
        origins: Float64[np.ndarray, "m nq"],
        displacements: Float64[np.ndarray, "m nv"],
        resolution: float,
    ) -> Bool[np.ndarray, " m"]:
        """Return the same for each pair of rows, shapes (m, nq) and (m, nv).

        Raises:
            Canceled: The request was canceled.
            DeadlineExceeded: The time has run out.
        """
        counts = steps_of(displacements, resolution)
        total = int(counts.sum())
        if not self._wrapping_indices and total <= _MAX_BATCH_STATES:
            self._deadline.check("search")
            self.num_states += total
            return self.inner.are_motions_free(origins, displacements, resolution)
        self.num_states += total
        free = self._are_motions_within_wrapping_limits(origins, displacements, resolution)
        is_long = counts > _MAX_BATCH_STATES
        for row in np.flatnonzero(free & is_long):
            free[row] = self._is_long_motion_free((origins[row], displacements[row]), resolution)
        for rows in _batches(np.flatnonzero(free & ~is_long), counts):
            self._deadline.check("search")
            free[rows] = self.inner.are_motions_free(origins[rows], displacements[rows], resolution)
        return free

    def _is_long_motion_free(self, motion: tuple[Array, Array], resolution: float) -> bool:
        for qs in sample_batches(self._manifold, motion, resolution):
            self._deadline.check("search")
            if not self.inner.are_free(qs).all():
                return False
        return True

    def _are_motions_within_wrapping_limits(
        self, origins: Array, displacements: Array, resolution: float
    ) -> Flags:
        """Return for every motion whether its samples keep the limits of wrapping joints."""
        if not self._wrapping_indices:
            return np.ones(len(origins), dtype=bool)
        verdicts = [
            all(
                self._are_within_wrapping_limits(qs).all()
                for qs in sample_batches(self._manifold, motion, resolution)
            )
            for motion in zip(origins, displacements, strict=True)
        ]
        return np.array(verdicts, dtype=bool)

    def _are_within_wrapping_limits(self, qs: Array) -> Flags:
        offsets = np.remainder(qs[:, self._wrapping_indices] - self._lower, 2 * np.pi)
        rounding = 1e-9
        return ((offsets <= self._widths + rounding) | (offsets >= 2 * np.pi - rounding)).all(
            axis=1
        )


def _batches(rows: Indices, counts: Indices) -> list[np.ndarray[Any, np.dtype[np.intp]]]:
    """Return the rows split into batches of at most about `_MAX_BATCH_STATES` states each."""
    if not len(rows):
        return []
    batch_index = np.cumsum(counts[rows]) // _MAX_BATCH_STATES
    return np.split(rows, np.flatnonzero(np.diff(batch_index)) + 1)


def _limited_wrapping_coordinates(
    group: JointGroup, limits: JointLimits
) -> tuple[list[int], Array, Array]:
    """Return coordinates of q that are limited angles on a circle, their lower limits, widths."""
    width = limits.upper - limits.lower
    indices: list[int] = []
    iq = 0
    for joint in group.joints:
        wraps = joint.wraps
        count = joint.num_positions
        if any(wraps):
            indices += [iq + k for k in range(count) if wraps[k] and width[iq + k] < 2 * np.pi]
        iq += count
    return indices, limits.lower[indices], width[indices]
