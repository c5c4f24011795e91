"""Goal configurations of a goal: the stage's one entry, shared by plans and by /ik."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64

from planning.domain.deadline import Deadline
from planning.domain.goal import ConfigurationGoal, Goal, JointGoal, PoseGoal
from planning.domain.joints import JointGroup
from planning.domain.options import IkOptions
from planning.domain.report import Funnel, GoalConfigurations
from planning.errors import GoalInCollision, GoalOutOfLimits, GoalUnreachable
from planning.goals.ik_program import IkProgram, ToolTarget
from planning.goals.nearest import nearest_pose
from planning.goals.ranking import equivalents, is_new, nearest_first
from planning.goals.seeds import seeds
from planning.goals.start import clip_dust, describe_pairs, limit_violations, pair_evidence
from planning.goals.tally import Tally, funnel_evidence
from planning.world.margins import PairMargins
from planning.world.positions import require_positions
from planning.world.world import World

type Array = np.ndarray[Any, np.dtype[np.float64]]

# So many converged free solutions in a row that were known already: there are no more.
_PATIENCE = 40


@dataclass(frozen=True)
class GoalQuery:
    """What the stage is asked.

    Attributes:
        group: Whose configurations are wanted.
        goal: What they shall reach.
        start: The group's q, shape (nq,); nearness is measured from here.
        margins: The distances to keep.
        options: How hard to look.
    """

    group: JointGroup
    goal: Goal
    start: Float64[np.ndarray, " nq"]
    margins: PairMargins
    options: IkOptions


def find_goals(
    world: World, query: GoalQuery, rng: np.random.Generator, deadline: Deadline
) -> GoalConfigurations:
    """Return every distinct, in-limit, free goal configuration, nearest to the start first.

    Raises:
        GoalOutOfLimits: Every given configuration violates position limits.
        GoalInCollision: Configurations exist and all of them collide.
        GoalUnreachable: No configuration reaches a target pose.
        ProblemInvalid: A given configuration has the wrong count.
        UnknownName: A frame or named configuration does not exist.
        DeadlineExceeded: Time ran out before a configuration was found.
        Canceled: Somebody asked for the end.
    """
    match query.goal:
        case PoseGoal() as goal:
            return _PoseSearch(world, query, goal, rng, deadline).run()
        case ConfigurationGoal() as goal:
            rows = world.configuration(query.group, goal.name)[None]
        case JointGoal() as goal:
            rows = np.stack([
                require_positions(query.group, q, f"goal.positions.{i}")
                for i, q in enumerate(goal.positions)
            ])
    return _given(world, query, rows)


def _given(world: World, query: GoalQuery, rows: Array) -> GoalConfigurations:
    """Keep those of the given configurations that are within limits and free."""
    rows = clip_dust(world, query.group, rows)
    outside = [limit_violations(world, query.group, q) for q in rows]
    inside = [i for i, violations in enumerate(outside) if not violations]
    if not inside:
        worst = max(outside[0], key=lambda entry: entry["violation"])
        message = (
            f"no goal configuration is within limits: {worst['joint']} = {worst['position']:.6g} "
            f"is not in [{worst['lower']:.6g}, {worst['upper']:.6g}]"
        )
        raise GoalOutOfLimits(message, {"joints": outside[0]})
    tally = Tally()
    free: list[tuple[int, Array]] = []
    for i in inside:
        pairs = world.violations(query.group, rows[i], query.margins)
        if pairs:
            tally.add(pairs, query.margins)
        else:
            free.append((i, rows[i]))
    funnel = Funnel(len(rows), len(rows), len(inside), len(free), len(free), tally.summary)
    if not free:
        pairs = world.violations(query.group, rows[inside[0]], query.margins)
        message = f"every goal configuration collides: {describe_pairs(pairs, query.margins)}"
        evidence = {"funnel": funnel_evidence(funnel), "pairs": pair_evidence(pairs, query.margins)}
        raise GoalInCollision(message, evidence)
    found, indices = nearest_first(query.group, query.start, free, len(free))
    return GoalConfigurations(found, indices, funnel)


class _PoseSearch:
    """One run of the sampler over the targets of a pose goal."""

    def __init__(
        self,
        world: World,
        query: GoalQuery,
        goal: PoseGoal,
        rng: np.random.Generator,
        deadline: Deadline,
    ) -> None:
        self._world = world
        self._query = query
        self._rng = rng
        self._deadline = deadline
        self._targets = tool_targets(world, query.group, goal, query.start)
        self._limits = world.limits(query.group)
        self._oracle = world.collision_oracle(query.group, query.margins)
        self._probe = world.distance_probe(query.margins)
        self._tried = self._converged = self._within = self._free = 0
        self._tally = Tally()
        self._found: list[tuple[int, Array]] = []

    def run(self) -> GoalConfigurations:
        options = self._query.options
        programs = [IkProgram(self._world, self._query.group, t) for t in self._targets]
        repeats = 0
        for seed in seeds(self._query.group, self._limits, self._query.start, self._rng):
            if self._is_done(repeats):
                break
            for i, program in enumerate(programs):
                if self._tried >= options.max_trials or self._deadline.is_over:
                    break
                self._tried += 1
                was, free = len(self._found), self._free
                self._admit(i, program.solve(seed))
                if len(self._found) > was:
                    repeats = 0
                elif self._free > free:
                    repeats += 1
        return self._answer()

    def _is_done(self, repeats: int) -> bool:
        options = self._query.options
        return (
            self._tried >= options.max_trials
            or len(self._found) >= options.max_configurations
            or repeats >= _PATIENCE
            or self._deadline.is_over
        )

    def _admit(self, target: int, q: Array | None) -> None:
        group, margins = self._query.group, self._query.margins
        if q is None:
            return
        self._converged += 1
        q = clip_dust(self._world, group, q)
        if limit_violations(self._world, group, q):
            return
        self._within += 1
        if not self._oracle.is_free(q):
            pairs = self._probe.violations(self._world.embed(group, q))
            if pairs:
                self._tally.add(pairs, margins)
            return
        self._free += 1
        if is_new(group, q, self._found, target):
            self._found.append((target, q))

    def _answer(self) -> GoalConfigurations:
        query = self._query
        funnel = Funnel(
            self._tried,
            self._converged,
            self._within,
            self._free,
            len(self._found),
            self._tally.summary,
        )
        if not self._found:
            self._deadline.check("goals")
            self._refuse(funnel)
        turned = [
            (target, row)
            for target, q in self._found
            for row in equivalents(query.group, self._limits, q)
        ]
        count = query.options.max_configurations
        rows, indices = nearest_first(query.group, query.start, turned, count)
        return GoalConfigurations(rows, indices, funnel)

    def _refuse(self, funnel: Funnel) -> None:
        """Raise what the funnel says: unreachable, or reachable only in collision."""
        if funnel.within_limits > 0:
            worst = funnel.rejected_by[:3]
            words = ", ".join(
                f"{tally.count} hit {'-'.join(tally.bodies)} by {1000 * tally.min_depth:.1f} to "
                f"{1000 * tally.max_depth:.1f} mm"
                for tally in worst
            )
            message = f"all {funnel.within_limits} configurations that reach the goal collide: "
            raise GoalInCollision(message + words, {"funnel": funnel_evidence(funnel)})
        query = self._query
        near = min(
            (
                nearest_pose(self._world, query.group, target, query.start, self._rng)
                for target in self._targets
            ),
            key=lambda found: found.translation_error + 0.1 * found.rotation_error,
        )
        message = (
            f"no configuration of {query.group.name} brings {self._targets[0].frame} to the goal; "
            f"the nearest pose is {1000 * near.translation_error:.1f} mm and "
            f"{np.degrees(near.rotation_error):.2f} deg away"
        )
        nearest = {
            "position": near.pose.position.tolist(),
            "quaternion": near.pose.quaternion.tolist(),
            "positions": near.positions.tolist(),
            "translation_error": near.translation_error,
            "rotation_error": near.rotation_error,
        }
        raise GoalUnreachable(message, {"funnel": funnel_evidence(funnel), "nearest": nearest})


def tool_targets(world: World, group: JointGroup, goal: PoseGoal, start: Array) -> list[ToolTarget]:
    """Return the goal's targets in world; a frame that moves counts where the start puts it.

    Raises:
        UnknownName: A frame does not exist.
    """
    tool = goal.frame or group.tool_frames[0]
    world.require_frame(tool)
    full = world.embed(group, start)
    return [
        ToolTarget(
            tool,
            world.frame_pose(target.frame, full) @ target.pose,
            goal.position_tolerance,
            goal.rotation_tolerance,
        )
        for target in goal.targets
    ]
