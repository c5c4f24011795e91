"""What a funnel says: why every sample that is no solution is none."""

from dataclasses import dataclass
from typing import Any

from planning.domain.report import Funnel, PairTally
from planning.domain.value import Value

# So many pairs of bodies are named in a sentence.
_TOLD = 3


@dataclass(frozen=True, eq=False)
class Rejection(Value):
    """Why some samples are no goal configurations.

    Attributes:
        reason: "not_converged", "outside_limits", "collision", "approach" (or retreat) or
            "duplicate".
        count: How many.
        pair: What they hit, if that is the reason and it was measured.
    """

    reason: str
    count: int
    pair: PairTally | None = None


def rejections(funnel: Funnel) -> tuple[Rejection, ...]:
    """Return why the others are not among the distinct ones.

    The counts and the distinct ones add up to what was tried. What collides is told by pair as far
    as it was measured; the rest of it has no pair.
    """
    colliding = funnel.within_limits - funnel.collision_free
    measured = sum(tally.count for tally in funnel.rejected_by)
    reasons = (
        Rejection("not_converged", funnel.tried - funnel.converged),
        Rejection("outside_limits", funnel.converged - funnel.within_limits),
        *(Rejection("collision", tally.count, tally) for tally in funnel.rejected_by),
        Rejection("collision", colliding - measured),
        Rejection("approach", funnel.collision_free - funnel.approach_ok),
        Rejection("duplicate", funnel.approach_ok - funnel.distinct),
    )
    return tuple(reason for reason in reasons if reason.count > 0)


def funnel_evidence(funnel: Funnel) -> dict[str, Any]:
    """Return all of it as JSON has it; shares are of what was tried."""
    return {
        "tried": funnel.tried,
        "converged": funnel.converged,
        "within_limits": funnel.within_limits,
        "collision_free": funnel.collision_free,
        "approach_ok": funnel.approach_ok,
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
                "leg": tally.leg,
                "reason": tally.reason,
                "where": tally.where,
                "count": tally.count,
                "max_fraction": tally.max_fraction,
            }
            for tally in funnel.blocked_by
        ],
        "rejected": [
            {
                "reason": one.reason,
                "count": one.count,
                "share": one.count / funnel.tried,
                "bodies": one.pair and list(one.pair.bodies),
                "min_depth": one.pair and one.pair.min_depth,
                "max_depth": one.pair and one.pair.max_depth,
            }
            for one in rejections(funnel)
        ],
        "summary": funnel_summary(funnel),
    }


def funnel_summary(funnel: Funnel) -> str:
    """Return the same as a sentence."""
    words = [f"{funnel.tried} tried", f"{funnel.converged} converged"]
    if funnel.converged > funnel.within_limits:
        words.append(f"{funnel.converged - funnel.within_limits} of them are outside limits")
    words += [
        f"{tally.count} of them hit {'-'.join(tally.bodies)} by "
        f"{1000 * tally.min_depth:.3g} to {1000 * tally.max_depth:.3g} mm"
        for tally in funnel.rejected_by[:_TOLD]
    ]
    told = sum(tally.count for tally in funnel.rejected_by[:_TOLD])
    others = funnel.within_limits - funnel.collision_free - told
    if others:
        words.append(f"{others} of them collide" + (" otherwise" if told else ""))
    if funnel.collision_free:
        words.append(f"{funnel.collision_free} are free")
    if funnel.collision_free > funnel.approach_ok:
        blocked = funnel.collision_free - funnel.approach_ok
        words.append(f"{blocked} of these have no free approach or retreat")
    if funnel.collision_free:
        words.append(f"{funnel.distinct} are distinct")
    return ", ".join(words)
