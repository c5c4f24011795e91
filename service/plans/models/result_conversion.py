"""MotionPlan to the wire."""

import dataclasses
from collections.abc import Sequence
from typing import Any

from planning.domain.goals.funnel import funnel_evidence
from planning.domain.report.certificate import Certificate
from planning.domain.report.motion_plan import MotionPlan, StageReports
from service.api.number_conversion import finite, listed
from service.plans.models.trajectory_conversion import check_wire
from service.scenes.models.pairs import Pair, unchecked_pairs


def plan_wire(
    plan: MotionPlan, trajectory: dict[str, Any], cuts: Sequence[str] = ()
) -> dict[str, Any]:
    """Return the `result` of a job.

    Args:
        plan: What was found.
        trajectory: Its samples.
        cuts: What a deadline cut after the plan.
    """
    return {
        "goal_configuration": listed(plan.goal_configuration),
        "goal_index": plan.goal_index,
        "start": listed(plan.start),
        "start_clipped": listed(plan.start_clipped),
        "path": listed(plan.path.waypoints),
        "parts": [dataclasses.asdict(part) for part in plan.parts],
        "trajectory": trajectory,
        "certificate": certificate_wire(plan.certificate),
        "stages": stages_wire(plan.stages),
        "cut_short": [*plan.cut_short, *cuts],
        "digest": plan.digest,
    }


def certificate_wire(certificate: Certificate) -> dict[str, Any]:
    """Return a certificate for the wire."""
    stopped = certificate.first_unproven
    return {
        "proven": certificate.proven,
        "min_clearance": finite(certificate.min_clearance),
        "observed_clearance": finite(certificate.observed_clearance),
        "pair": list(certificate.pair),
        "time": certificate.time,
        "points": listed(certificate.points),
        "proven_until": certificate.proven_until,
        "first_unproven": None if stopped is None else Pair.from_domain(stopped).model_dump(),
        "unchecked": unchecked_pairs(certificate.unchecked),
        "checks": [check_wire(check) for check in certificate.checks],
    }


def stages_wire(stages: StageReports) -> dict[str, Any]:
    """Return the reports of all stages for the wire."""
    certify = dataclasses.asdict(stages.certify)
    return {
        "goals": {
            "num_configurations": len(stages.goals.positions),
            "funnel": funnel_evidence(stages.goals.funnel),
        },
        "search": dataclasses.asdict(stages.search),
        "refine": dataclasses.asdict(stages.refine),
        "retime": dataclasses.asdict(stages.retime),
        "certify": {**certify, "refused": list(stages.certify.refused)},
    }
