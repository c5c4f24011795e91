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
from planning.goals.lines.approach import ApproachChecker
from planning.goals.ranking import UniqueSolutions
from planning.goals.start import clip_rounding, within_limits
from planning.goals.targets.target_samples import TargetSamples
from planning.world.world import World

# Consecutive duplicates among free solutions after which the search ends.
_PATIENCE = 40


class PoseSearch:
    """IK search of one goal, with its results and counts.

    The results do not depend on how many seeds the solver takes at once.

    Attributes:
        judge: Check of approach and retreat; None if the goal has neither.
        found: Distinct feasible solutions so far.
        blocked: Distinct free solutions without a free approach or retreat.
        colliding: Solutions within limits that violate the margin of a body pair.
    """

    def __init__(
        self,
        world: World,
        query: GoalQuery,
        rng: np.random.Generator,
        deadline: Deadline,
        judge: ApproachChecker | None = None,
    ) -> None:
        """Prepare to search; with a judge only solutions with approach and retreat are kept."""
        self._query = query
        self._deadline = deadline
        self._limits = world.limits(query.group)
        self._oracle = world.collision_oracle(query.group, query.margins)
        self._seeds = Seeds(query.group, self._limits, query.start, rng)
        self._drawn = self._seeds.take(0)
        self._tried = self._converged = self._within = self._free = self._repeats = 0
        self._approached = self._breaking = 0
        self._wanted = query.options.max_configurations
        self.judge = judge
        self._manifold = Manifold(query.group.joints)
        self.found = UniqueSolutions(query.group, self._manifold)
        self.blocked = UniqueSolutions(query.group, self._manifold)
        self.colliding: list[Array] = []

    def run(self, aims: TargetSamples, solver: PoseSolver, max_trials: int) -> None:
        """Try seeds until `is_done`, or the target samples are used up.

        Args:
            aims: Target samples of the trials.
            solver: IK solver for the targets of these.
            max_trials: Largest number of trials, counted over all runs.
        """
        end = aims.end_within(max_trials)
        while self._tried < end and not self.is_done(max_trials):
            count = min(solver.num_at_once, end - self._tried)
            seeds, targets = aims.trials(self._tried, count)
            # Twice as many, since some collide and some are duplicates.
            enough = 2 * (self._wanted - len(self.found))
            converged, q = solver.solve(self._rows(seeds), targets, enough)
            try:
                self._admit(converged, q, aims.poses[targets[: len(q)]])
            except DeadlineExceeded:
                # Trials that were not checked in time do not count.
                return

    def funnel(self, rejected_by: tuple[PairTally, ...]) -> Funnel:
        """Return the number of trials that passed each stage of the search.

        Args:
            rejected_by: Tally of the body pairs of colliding solutions.
        """
        return Funnel(
            self._tried,
            self._converged,
            self._within,
            self._free,
            len(self.found),
            rejected_by,
            breaking=self._breaking,
            approach_ok=self._approached,
            blocked_by=self.judge.blocked_by if self.judge else (),
        )

    def is_done(self, max_trials: int) -> bool:
        """Return whether solutions suffice, trials or time are used up, or only duplicates come."""
        return (
            self._tried >= max_trials
            or len(self.found) >= self._wanted
            or self._repeats >= _PATIENCE
            or self._deadline.is_over
        )

    def _rows(self, seeds: Indices) -> Array:
        """Return the seeds of ascending numbers, drawing more as needed."""
        missing = int(seeds[-1]) + 1 - len(self._drawn)
        if missing > 0:
            self._drawn = np.concatenate([self._drawn, self._seeds.take(missing)])
        return self._drawn[seeds]

    def _admit(self, converged: Flags, q: Array, poses: Indices) -> None:
        """Count the results of a batch and add the new solutions, in the order of the seeds."""
        q = clip_rounding(self._limits, self._manifold, q)
        within = converged & within_limits(self._limits, q)
        free, is_new = np.zeros_like(within), np.zeros_like(within)
        free[within] = self._oracle.are_free(q[within])
        kept = self._kept(q, free)
        is_new[kept] = self.found.are_new(q[kept], poses[kept])
        good = kept if self.judge is None else self._approachable(q, poses, kept, is_new)
        end = self._end(good, is_new)
        self._tried += end
        self._converged += int(converged[:end].sum())
        self._within += int(within[:end].sum())
        self._free += int(free[:end].sum())
        self._breaking += int((free & ~kept)[:end].sum())
        self._approached += int(good[:end].sum())
        self.colliding += list(q[:end][(within & ~free)[:end]])
        is_added = is_new[:end]
        self.found.add(q[:end][is_added], poses[:end][is_added])

    def _kept(self, q: Array, free: Flags) -> Flags:
        """Return which of the free rows satisfy the query's path constraints."""
        kept = np.array(free)
        if self._query.rules is not None:
            kept[free] = self._query.rules.are_kept(q[free])
        return kept

    def _approachable(self, q: Array, targets: Indices, free: Flags, is_new: Flags) -> Flags:
        """Return which of the free rows have approach and retreat; clear `is_new` of the others."""
        good = np.array(free)
        is_new[free] &= ~self.blocked.contains(q[free], targets[free])
        asked = np.flatnonzero(is_new)
        if self.judge is not None and len(asked):
            bad = asked[~self.judge.admit(q[asked], targets[asked])]
            self.blocked.add(q[bad], targets[bad])
            is_new[bad] = False
        good[free] = ~self.blocked.contains(q[free], targets[free])
        return good

    def _end(self, free: Flags, is_new: Flags) -> int:
        """Return the number of rows that count: up to the one that ends the search."""
        found = len(self.found)
        for i in np.flatnonzero(free):
            if is_new[i]:
                found += 1
                self._repeats = 0
            else:
                self._repeats += 1
            if found >= self._wanted or self._repeats >= _PATIENCE:
                return int(i) + 1
        return len(free)
