"""Funnel: number of IK samples that pass each test, and the reasons of rejection."""

from dataclasses import dataclass
from typing import Any

from planning.domain.value import Value

# Number of pairs of bodies named in a sentence.
_MAX_NAMED_PAIRS = 3


@dataclass(frozen=True, eq=False)
class PairTally(Value):
    """Count of rejected configurations in which one pair of bodies is the deepest collision.

    Attributes:
        bodies: Full names.
        count: Rejected configurations.
        min_depth: Smallest depth among them [m].
        max_depth: Largest depth among them [m].
    """

    bodies: tuple[str, str]
    count: int
    min_depth: float
    max_depth: float


@dataclass(frozen=True, eq=False)
class LinearMoveTally(Value):
    """Count of configurations whose approach or retreat stops for one reason.

    Attributes:
        move: "approach" or "retreat".
        reason: As in `LineStop`.
        where: The pair of bodies or the joint, or "".
        count: Configurations.
        max_fraction: Largest reached fraction of the line, from the goal outwards.
    """

    move: str
    reason: str
    where: str
    count: int
    max_fraction: float


@dataclass(frozen=True, eq=False)
class Funnel(Value):
    """Numbers of IK samples that pass each test.

    In the order of the tests, from `num_samples` through `num_with_linear_moves` to `distinct`, no
    number is larger than the one before it.

    Attributes:
        num_samples: Seeds given to the solver.
        converged: Reached the target within tolerance.
        within_limits: Within the joint limits.
        collision_free: Free of collision.
        distinct: Different from all others; configurations that differ by whole turns of joints
            count once here.
        rejected_by: Colliding pairs of the rejected configurations; only the first few are
            measured, more of them if none is free.
        num_goals_violating: Goal configurations, whole turns included, that were dropped because
            they or their linear moves violate a path constraint.
        num_with_linear_moves: Of the collision-free ones that keep the path constraints, those
            whose approach and retreat are free and continuous; all of them if neither is requested.
            The distinct ones are among these.
        num_samples_violating: Of the collision-free ones, those that violate a path constraint.
        blocked_by: Reasons at which approaches and retreats stopped, most frequent first.
    """

    num_samples: int = 0
    converged: int = 0
    within_limits: int = 0
    collision_free: int = 0
    distinct: int = 0
    rejected_by: tuple[PairTally, ...] = ()
    num_goals_violating: int = 0
    num_with_linear_moves: int = 0
    blocked_by: tuple[LinearMoveTally, ...] = ()
    num_samples_violating: int = 0


@dataclass(frozen=True, eq=False)
class Rejection(Value):
    """Reason why some samples are no goal configurations.

    Attributes:
        reason: "not_converged", "outside_limits", "collision", "path_constraint", "approach" (or
            retreat) or "duplicate".
        count: Number of samples.
        pair: The colliding pair, if that is the reason and it was measured.
    """

    reason: str
    count: int
    pair: PairTally | None = None


def rejections(funnel: Funnel) -> tuple[Rejection, ...]:
    """Return why the other samples are not among the distinct ones.

    The counts and the distinct ones add up to the samples tried. Collisions are listed by pair as
    far as they were measured; the rest of them has no pair.
    """
    colliding = funnel.within_limits - funnel.collision_free
    measured = sum(tally.count for tally in funnel.rejected_by)
    reasons = (
        Rejection("not_converged", funnel.num_samples - funnel.converged),
        Rejection("outside_limits", funnel.converged - funnel.within_limits),
        *(Rejection("collision", tally.count, tally) for tally in funnel.rejected_by),
        Rejection("collision", colliding - measured),
        Rejection("path_constraint", funnel.num_samples_violating),
        Rejection(
            "approach",
            funnel.collision_free - funnel.num_samples_violating - funnel.num_with_linear_moves,
        ),
        Rejection("duplicate", funnel.num_with_linear_moves - funnel.distinct),
    )
    return tuple(reason for reason in reasons if reason.count > 0)


def funnel_evidence(funnel: Funnel) -> dict[str, Any]:
    """Return all of it as JSON; shares are of the samples tried."""
    return {
        "tried": funnel.num_samples,
        "converged": funnel.converged,
        "within_limits": funnel.within_limits,
        "collision_free": funnel.collision_free,
        "breaking": funnel.num_samples_violating,
        "violating": funnel.num_goals_violating,
        "approach_ok": funnel.num_with_linear_moves,
        "distinct": funnel.distinct,
        "rejected_by": [
            {
                "bodies": list(tally.bodies),
                "count": tally.count,
                "min_depth": tally.min_depth,
                "max_depth": tally.max_depth,
            }
            for tally in funnel.rejected_by
        ],
        "blocked_by": [
            {
                "leg": tally.move,
                "reason": tally.reason,
                "where": tally.where,
                "count": tally.count,
                "max_fraction": tally.max_fraction,
            }
            for tally in funnel.blocked_by
        ],
        "rejected": [
            {
                "reason": rejection.reason,
                "count": rejection.count,
                "share": rejection.count / funnel.num_samples,
                "bodies": rejection.pair and list(rejection.pair.bodies),
                "min_depth": rejection.pair and rejection.pair.min_depth,
                "max_depth": rejection.pair and rejection.pair.max_depth,
            }
            for rejection in rejections(funnel)
        ],
        "summary": funnel_summary(funnel),
    }


def funnel_summary(funnel: Funnel) -> str:
    """Return the same as a sentence."""
    phrases = [f"{funnel.num_samples} tried", f"{funnel.converged} converged"]
    if funnel.converged > funnel.within_limits:
        phrases.append(f"{funnel.converged - funnel.within_limits} of them are outside limits")
    phrases += _collision_phrases(funnel)
    if funnel.collision_free:
        phrases.append(f"{funnel.collision_free} are free")
    if funnel.num_samples_violating:
        phrases.append(f"{funnel.num_samples_violating} of these violate a path constraint")
    blocked = funnel.collision_free - funnel.num_samples_violating - funnel.num_with_linear_moves
    if blocked > 0:
        phrases.append(f"{blocked} of these have no free approach or retreat")
    if funnel.collision_free:
        phrases.append(f"{funnel.distinct} are distinct")
    return ", ".join(phrases)


def _collision_phrases(funnel: Funnel) -> list[str]:
    """Return how many samples collide, and in which pairs of bodies, the most frequent first."""
    named = [
        f"{tally.count} of them hit {'-'.join(tally.bodies)} by "
        f"{1000 * tally.min_depth:.3g} to {1000 * tally.max_depth:.3g} mm"
        for tally in funnel.rejected_by[:_MAX_NAMED_PAIRS]
    ]
    num_others = sum(tally.count for tally in funnel.rejected_by[_MAX_NAMED_PAIRS:])
    if num_others:
        named.append(f"{num_others} of them hit other pairs")
    num_colliding = funnel.within_limits - funnel.collision_free
    num_measured = sum(tally.count for tally in funnel.rejected_by)
    if num_measured >= num_colliding:
        return named
    colliding = f"{num_colliding} of them collide"
    if not named:
        return [colliding]
    return [f"{colliding} ({num_measured} measured: {', '.join(named)})"]
