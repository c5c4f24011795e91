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
from planning.errors import NotCertified
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
