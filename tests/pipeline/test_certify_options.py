"""What a plan is asked to find out about its motion changes no byte of the motion."""

import time
from dataclasses import replace

import numpy as np
import pytest

import planning
from planning.domain.deadline import Deadline
from planning.domain.goal import JointGoal
from planning.domain.options import CertifyOptions
from planning.domain.plan import MotionPlan
from planning.domain.problem import PlanningProblem
from planning.domain.value import digest
from planning.errors import NotCertified, ProblemInvalid
from planning.world.world import World


def planned(world: World, problem: PlanningProblem) -> MotionPlan:
    return planning.plan(problem, world, deadline=Deadline.after(60.0, time.monotonic))


def test_findings_come_with_the_same_motion(pickup: World) -> None:
    home = pickup.positions(pickup.group("arm"))
    goal = JointGoal((home + np.array([-0.6, 0.1, -0.2, 0.1, 0.0, 0.3]))[None])
    problem = PlanningProblem("arm", goal, refine=planning.RefineOptions("none"))
    plain = planned(pickup, problem)
    assert (plain.stages.certify.stop, plain.stages.certify.robustness) == (None, None)
    asked = planned(pickup, replace(problem, certify=CertifyOptions(True, None, True)))
    assert digest(asked.trajectory) == digest(plain.trajectory)
    assert asked.certificate.checks[:-1] == plain.certificate.checks
    stop, robustness = asked.stages.certify.stop, asked.stages.certify.robustness
    assert stop is not None
    assert robustness is not None
    assert robustness.obstacle_displacement > robustness.joint_error > 0
    enough = CertifyOptions(max_stopping_time=stop.time + 1e-9)
    assert planned(pickup, replace(problem, certify=enough)).stages.certify.stop == stop
    hasty = replace(problem, certify=CertifyOptions(max_stopping_time=stop.time / 3))
    with pytest.raises(NotCertified) as refused:
        planned(pickup, hasty)
    assert {check["name"] for check in refused.value.evidence["checks"]} == {"stop"}


@pytest.mark.parametrize(
    ("limits", "named"),
    [
        (planning.RetimeOptions(effort=True), ["effort"]),
        (
            planning.RetimeOptions(tool_limits=(planning.ToolLimit("arm::tcp", None, 1.0),)),
            ["tool_limits"],
        ),
    ],
)
def test_stops_have_no_bound_where_they_are_not_held_to_all_limits(
    pickup: World, limits: planning.RetimeOptions, named: list[str]
) -> None:
    home = pickup.positions(pickup.group("arm"))
    problem = PlanningProblem(
        "arm",
        JointGoal((home + 0.1)[None]),
        retime=limits,
        certify=CertifyOptions(max_stopping_time=1.0),
    )
    with pytest.raises(ProblemInvalid) as refused:
        planned(pickup, problem)
    assert refused.value.evidence["field"] == "certify.max_stopping_time"
    assert refused.value.evidence["limits"] == named
    motion = planning.trajectory_through(
        pickup.group("arm").joints, np.array([0.0, 2.0]), np.stack([home, home + 0.1])
    )
    soon = Deadline.after(9.0, time.monotonic)
    with pytest.raises(ProblemInvalid, match="max_stopping_time"):
        planning.certify_trajectory(
            pickup, "arm", motion, deadline=soon, options=limits, wanted=problem.certify
        )
    # Their length may still be asked for, and speeds of frames are kept by every stop.
    slow = planning.RetimeOptions(tool_limits=(planning.ToolLimit("arm::tcp", 1.0),))
    for options, wanted in ((limits, CertifyOptions(stop_anywhere=True)), (slow, problem.certify)):
        _, report = planning.certify_trajectory(
            pickup, "arm", motion, deadline=soon, options=options, wanted=wanted
        )
        assert report.stop is not None
