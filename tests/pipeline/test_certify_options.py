"""Options of the certification do not change the motion by a byte."""

from dataclasses import replace

import numpy as np
import pytest

import planning
from planning.domain.goals.goal import JointGoal
from planning.domain.report.motion_plan import MotionPlan
from planning.domain.request.options import CertifyOptions
from planning.domain.request.problem import PlanningProblem
from planning.domain.value import digest
from planning.errors import NotCertified
from planning.world.world import World
from tests.clocks import no_hurry


def planned(world: World, problem: PlanningProblem) -> MotionPlan:
    return planning.plan(problem, world, deadline=no_hurry(60.0))


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
    "limits",
    [
        planning.RetimeOptions(effort=True),
        planning.RetimeOptions(tool_limits=(planning.ToolLimit("arm::tcp", None, 1.0),)),
    ],
)
def test_stops_are_bounded_under_all_that_limits_the_motion(
    pickup: World, limits: planning.RetimeOptions
) -> None:
    home = pickup.positions(pickup.group("arm"))
    path = np.stack([home, home + np.array([-0.6, 0.1, -0.2, 0.1, 0.0, 0.3])])
    soon = no_hurry(30.0)
    motion = planning.retime_path(pickup, "arm", path, deadline=soon, options=limits).trajectory
    hasty = CertifyOptions(max_stopping_time=0.01)
    certificate, report = planning.certify_trajectory(
        pickup, "arm", motion, deadline=soon, options=limits, certify_options=hasty
    )
    assert report.stop is not None
    assert 0.01 < report.stop.time < motion.duration
    assert (report.stop.unheld, report.stop.unheld_at) == ("", None)
    assert [check.name for check in certificate.failed] == ["stop"]
