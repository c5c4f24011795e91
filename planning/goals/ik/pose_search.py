"""PoseSearch: IK sampling from many seeds, filtered by limits, collisions, constraints, lines."""

import numpy as np

from planning.domain.arrays import Array, Flags, Indices
from planning.domain.goals.funnel import Funnel, PairTally
from planning.domain.request.deadline import Deadline
from planning.domain.robot.manifold import Manifold
from planning.errors import DeadlineExceeded
from planning.goals.goal_query import GoalQuery
from planning.goals.ik.pose_solvers import PoseSolver
from planning.goals.ik.seeds import Seeds
from planning.goals.lines.approach_checker import ApproachChecker
from planning.goals.ranking import UniqueSolutions
from planning.goals.start_validation import clip_rounding, within_limits
from planning.goals.targets.target_samples import TargetSamples
from planning.world.world import World

# Consecutive duplicates among free solutions after which the search ends.
_PATIENCE = 40


class PoseSearch:
    """IK search of one goal, with its results and counts.

    The results do not depend on how many seeds the solver takes at once.

    Attributes:
        checker: Check of approach and retreat; None if the goal has neither.
        solutions: Distinct feasible solutions so far.
        blocked: Distinct free solutions without a free approach or retreat.
        colliding: Solutions within limits that violate the margin of a body pair.
    """

    def __init__(
        self,
        world: World,
        query: GoalQuery,
        rng: np.random.Generator,
        deadline: Deadline,
        checker: ApproachChecker | None = None,
    ) -> None:
        """Prepare to search; with a checker only solutions with approach and retreat are kept."""
        self._query = query
        self._deadline = deadline
        self._limits = world.limits(query.group)
        self._oracle = world.collision_oracle(query.group, query.margins)
        self._seeds = Seeds(query.group, self._limits, query.start, rng)
        self._drawn_seeds = self._seeds.take(0)
        self._num_tried = self._num_converged = self._num_within_limits = self._num_free = 0
        self._num_approachable = self._num_violating = self._num_repeats = 0
        self._num_wanted = query.options.max_configurations
        self.checker = checker
        self._manifold = Manifold(query.group.joints)
        self.solutions = UniqueSolutions(query.group, self._manifold)
        self.blocked = UniqueSolutions(query.group, self._manifold)
        self.colliding: list[Array] = []

    def run(self, samples: TargetSamples, solver: PoseSolver, max_trials: int) -> None:
        """Try seeds until `is_done`, or the target samples are used up.

        Args:
            samples: Target samples of the trials.
            solver: IK solver for the targets of these.
            max_trials: Largest number of trials, counted over all runs.
        """
        end = samples.end_within(max_trials)
        while self._num_tried < end and not self.is_done(max_trials):
            count = min(solver.batch_size, end - self._num_tried)
            seeds, targets = samples.trials(self._num_tried, count)
            # Twice as many, since some collide and some are duplicates.
            num_required = 2 * (self._num_wanted - len(self.solutions))
            converged, q = solver.solve(self._seed_rows(seeds), targets, num_required)
            try:
                self._add_batch(converged, q, samples.pose_indices[targets[: len(q)]])
            except DeadlineExceeded:
                # Trials that were not checked in time do not count.
                return

    def funnel(self, rejected_by: tuple[PairTally, ...]) -> Funnel:
        """Return the number of trials that passed each stage of the search.

        Args:
            rejected_by: Tally of the body pairs of colliding solutions.
        """
        return Funnel(
            self._num_tried,
            self._num_converged,
            self._num_within_limits,
            self._num_free,
            len(self.solutions),
            rejected_by,
            num_samples_violating=self._num_violating,
            num_with_linear_moves=self._num_approachable,
            blocked_by=self.checker.blocked_by if self.checker else (),
        )

    def is_done(self, max_trials: int) -> bool:
        """Return whether solutions suffice, trials or time are used up, or only duplicates come."""
        return (
            self._num_tried >= max_trials
            or len(self.solutions) >= self._num_wanted
            or self._num_repeats >= _PATIENCE
            or self._deadline.is_over
        )

    def _seed_rows(self, seeds: Indices) -> Array:
        """Return the seeds of ascending numbers, drawing more as needed."""
        missing = int(seeds[-1]) + 1 - len(self._drawn_seeds)
        if missing > 0:
            drawn, kept = np.array(self._seeds.take(missing)), self._query.kept
            if kept is not None:
                drawn[:, kept] = self._query.start[kept]
            self._drawn_seeds = np.concatenate([self._drawn_seeds, drawn])
        return self._drawn_seeds[seeds]

    def _add_batch(self, converged: Flags, q: Array, poses: Indices) -> None:
        """Count the results of a batch and add the new solutions, in the order of the seeds."""
        q = clip_rounding(self._limits, self._manifold, q)
        is_within_limits = converged & within_limits(self._limits, q)
        is_free, is_new = np.zeros_like(is_within_limits), np.zeros_like(is_within_limits)
        is_free[is_within_limits] = self._oracle.are_free(q[is_within_limits])
        is_satisfied = self._satisfy_constraints(q, is_free)
        is_new[is_satisfied] = self.solutions.are_new(q[is_satisfied], poses[is_satisfied])
        is_approachable = (
            is_satisfied
            if self.checker is None
            else self._approachable(q, poses, is_satisfied, is_new)
        )
        num_counted = self._num_rows_counted(is_approachable, is_new)
        self._num_tried += num_counted
        self._num_converged += int(converged[:num_counted].sum())
        self._num_within_limits += int(is_within_limits[:num_counted].sum())
        self._num_free += int(is_free[:num_counted].sum())
        self._num_violating += int((is_free & ~is_satisfied)[:num_counted].sum())
        self._num_approachable += int(is_approachable[:num_counted].sum())
        self.colliding += list(q[:num_counted][(is_within_limits & ~is_free)[:num_counted]])
        is_added = is_new[:num_counted]
        self.solutions.add(q[:num_counted][is_added], poses[:num_counted][is_added])

    def _satisfy_constraints(self, q: Array, is_free: Flags) -> Flags:
        """Return which of the free rows satisfy the query's path constraints."""
        is_satisfied = np.array(is_free)
        if self._query.constraints is not None:
            is_satisfied[is_free] = self._query.constraints.are_satisfied(q[is_free])
        return is_satisfied

    def _approachable(self, q: Array, targets: Indices, is_free: Flags, is_new: Flags) -> Flags:
        """Return which of the free rows have approach and retreat; clear `is_new` of the others."""
        is_approachable = np.array(is_free)
        is_new[is_free] &= ~self.blocked.contains(q[is_free], targets[is_free])
        new_indices = np.flatnonzero(is_new)
        if self.checker is not None and len(new_indices):
            blocked_indices = new_indices[~self.checker.check(q[new_indices], targets[new_indices])]
            self.blocked.add(q[blocked_indices], targets[blocked_indices])
            is_new[blocked_indices] = False
        is_approachable[is_free] = ~self.blocked.contains(q[is_free], targets[is_free])
        return is_approachable

    def _num_rows_counted(self, is_free: Flags, is_new: Flags) -> int:
        """Return the number of rows that count: up to the one that ends the search."""
        num_found = len(self.solutions)
        for i in np.flatnonzero(is_free):
            if is_new[i]:
                num_found += 1
                self._num_repeats = 0
            else:
                self._num_repeats += 1
            if num_found >= self._num_wanted or self._num_repeats >= _PATIENCE:
                return int(i) + 1
        return len(is_free)
