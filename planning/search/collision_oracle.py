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
from planning.domain.robot.wrapping_limits import WrappingLimits

# Most states in one call of the inner oracle between two checks of the deadline (or one motion).
_MAX_BATCH_STATES = 4096
# Most edges in one call, of which the first free one is sought.
_MAX_BATCH_EDGES = 32


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
    """Oracle that checks edges between configurations, which takes it less time than motions."""

    def is_edge_free(self, q0: list[float], q1: list[float], resolution: float) -> tuple[bool, int]:
        """Return whether the straight edge is free, both ends included, and its number of steps."""
        ...

    def are_edges_free(
        self, q0s: Array, q1s: Array, resolution: float, max_steps: int
    ) -> tuple[Flags, int] | None:
        """Return whether each edge is free, as its motion, and the number of all steps.

        None if there are more than `max_steps`. Shapes (m, nq).
        """
        ...

    def first_free_edge(
        self, q0s: Array, q1s: Array, resolution: float, max_steps: int
    ) -> tuple[int, bool, int]:
        """Return the index of the first free edge, or of one before it that is not decided.

        With it, whether it is decided, and the number of steps without those of one that is not: it
        may have more than `max_steps`. The index is the number of edges if none is free. Shapes
        (m, nq) or (1, nq).
        """
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
        self._edge_oracle = inner if isinstance(inner, EdgeOracle) else None
        self._check_edge = (
            self._check_edge_as_motion
            if self._edge_oracle is None
            else self._edge_oracle.is_edge_free
        )
        self._manifold = Manifold.of(group.joints)
        self._wrapping = WrappingLimits.of(group, limits)
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

    @property
    def native_checker(self) -> Any | None:
        """The kernel's checker of the joints, if the oracle has one and they do not wrap."""
        return None if self._wrapping.indices else getattr(self.inner, "native_checker", None)

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
        if self._wrapping.indices and not self._wrapping.are_within(q[None])[0]:
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
        return verdicts & self._wrapping.are_within(qs) if self._wrapping.indices else verdicts

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
        if self._wrapping.indices or steps > _MAX_BATCH_STATES:
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

    def are_edges_free(
        self,
        q0s: Float64[np.ndarray, "m nq"],
        q1s: Float64[np.ndarray, "m nq"],
        resolution: float,
    ) -> Bool[np.ndarray, " m"]:
        """Return whether the motion from each q0 to its q1 is admissible.

        Only for joints that neither wrap nor float.

        Raises:
            Canceled: The request was canceled.
            DeadlineExceeded: The time has run out.
        """
        if self._edge_oracle is not None:
            self._deadline.check("search")
            found = self._edge_oracle.are_edges_free(q0s, q1s, resolution, _MAX_BATCH_STATES)
            if found is not None:
                self.num_states += found[1]
                return found[0]
        return self.are_motions_free(q0s, q1s - q0s, resolution)

    def first_free_edge(
        self,
        q0s: Float64[np.ndarray, "#m nq"],
        q1s: Float64[np.ndarray, "#m nq"],
        resolution: float,
    ) -> int:
        """Return the index of the first motion from a q0 to its q1 that is admissible.

        It is the number of motions if none is. One q0 or one q1 may be that of all motions. Only
        for joints that neither wrap nor float.

        Raises:
            Canceled: The request was canceled.
            DeadlineExceeded: The time has run out.
        """
        index, count = 0, len(q1s) if len(q0s) == 1 else len(q0s)
        while index < count:
            here = slice(index, index + _MAX_BATCH_EDGES)
            begins, ends = (qs[here] if len(qs) == count else qs for qs in (q0s, q1s))
            num_blocked, is_decided = 0, False
            if self._edge_oracle is not None:
                self._deadline.check("search")
                num_blocked, is_decided, steps = self._edge_oracle.first_free_edge(
                    begins, ends, resolution, _MAX_BATCH_STATES
                )
                self.num_states += steps
            index += num_blocked
            if is_decided and num_blocked < max(len(begins), len(ends)):
                return index
            if not is_decided:
                begin, end = q0s[min(index, len(q0s) - 1)], q1s[min(index, len(q1s) - 1)]
                if self.is_motion_free(begin, end - begin, resolution):
                    return index
                index += 1
        return count

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
        if not self._wrapping.indices and total <= _MAX_BATCH_STATES:
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
        if not self._wrapping.indices:
            return np.ones(len(origins), dtype=bool)
        verdicts = [
            all(
                self._wrapping.are_within(qs).all()
                for qs in sample_batches(self._manifold, motion, resolution)
            )
            for motion in zip(origins, displacements, strict=True)
        ]
        return np.array(verdicts, dtype=bool)


def _batches(rows: Indices, counts: Indices) -> list[np.ndarray[Any, np.dtype[np.intp]]]:
    """Return the rows split into batches of at most about `_MAX_BATCH_STATES` states each."""
    if not len(rows):
        return []
    batch_index = np.cumsum(counts[rows]) // _MAX_BATCH_STATES
    return np.split(rows, np.flatnonzero(np.diff(batch_index)) + 1)
