"""Refinement that knows limits besides those of joints: proven, and quicker for it."""

import numpy as np
import pytest

import planning
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import JointGoal
from planning.domain.report.motion_plan import MotionPlan
from planning.domain.request.constraint import PlacedBox
from planning.domain.request.motion_limits import MotionLimits, SpeedZone, ToolLimit
from planning.domain.request.options import RefineOptions, RetimeOptions, SearchOptions
from planning.domain.request.problem import PlanningProblem
from planning.domain.robot.payload import Payload
from planning.errors import RetimingFailed
from planning.refine.refiner import refine
from planning.refine.request import RefineRequest
from planning.retime.limits.request_limits import path_limits
from planning.retime.retimer import retime
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases
from tests.refine.arms import ARMS

FRAMES = {name: frame for name, (_, _, frame, _) in ARMS.items()}
# In the scenes' open part, and behind what is in the way.
OPEN = {
    "ur5e": [0.9, -1.97, 2.27, -2.17, -1.07, 0.3],
    "panda": [0.9, -1.19, 0.7, -2.96, 0.5, 1.87, 1.69],
}
BEHIND = {
    "ur5e": [-0.44, -1.29, 2.47, -1.48, -2.83, 2.49],
    "panda": [-0.77, -1.66, -0.96, -2.9, 2.15, 0.08, -1.37],
}
BOUNDS = {
    "ur5e": {"arm::shoulder_pan_joint": (-2.0, 9.0), "arm::shoulder_lift_joint": (-9.0, 1.0)},
    "panda": {"panda::panda_joint1": (-2.0, 9.0), "panda::panda_joint2": (-9.0, 1.0)},
}
SPEED = {
    name: RetimeOptions(tool_limits=(ToolLimit(frame, speed=0.4),))
    for name, frame in FRAMES.items()
}
ACCELERATION = {
    name: RetimeOptions(tool_limits=(ToolLimit(frame, acceleration=1.5),))
    for name, frame in FRAMES.items()
}
SIGNED = {name: RetimeOptions(acceleration_bounds=bounds) for name, bounds in BOUNDS.items()}
ON_THE_WAY = {"ur5e": [0.31, 0.36, 0.3], "panda": [0.24, 0.16, 0.43]}
SLOW = {
    name: SpeedZone("slow", frame, PlacedBox(np.full(3, 0.15), Pose.from_parts(place)), 0.15)
    for (name, place), frame in zip(ON_THE_WAY.items(), FRAMES.values(), strict=True)
}
RUCKIG = RetimeOptions("ruckig", tool_limits=SPEED["panda"].tool_limits)


def carrying(name: str, mass: float) -> RetimeOptions:
    carried = Payload.from_parts(FRAMES[name], mass, (0.0, 0.0, 0.05))
    return RetimeOptions(effort=True, payload=carried)


CASES = {
    "ur5e, acceleration": ("ur5e", OPEN, ACCELERATION["ur5e"]),
    "ur5e, signed": ("ur5e", BEHIND, SIGNED["ur5e"]),
    "panda, torque": ("panda", BEHIND, carrying("panda", 3.5)),
    "ur5e, zone": ("ur5e", OPEN, RetimeOptions(speed_zones=(SLOW["ur5e"],))),
    # In a campaign only:
    "ur5e, speed": ("ur5e", OPEN, SPEED["ur5e"]),
    "panda, speed": ("panda", OPEN, SPEED["panda"]),
    "panda, acceleration": ("panda", OPEN, ACCELERATION["panda"]),
    "panda, signed": ("panda", BEHIND, SIGNED["panda"]),
    "panda, ruckig": ("panda", OPEN, RUCKIG),
    "panda, zone": ("panda", OPEN, RetimeOptions("ruckig", speed_zones=(SLOW["panda"],))),
}


def solve(name: str, goal: list[float], timing: RetimeOptions, refine: str) -> MotionPlan:
    scene, group, _, _ = ARMS[name]
    problem = PlanningProblem(
        group,
        JointGoal(np.array([goal])),
        search=SearchOptions(allowed_planning_time=30.0),
        refine=RefineOptions(refine),
        retime=timing,
        seed=2,
    )
    within = no_hurry(30.0)
    return planning.plan(problem, bundled_world(scene), deadline=within)


def refined(found: MotionPlan, name: str, timing: RetimeOptions, others: MotionLimits) -> float:
    """Return how long a plan's path takes if refinement knows of other limits or not [s].

    Endless if refinement finds nothing that is quicker than the path.
    """
    world, group = bundled_world(ARMS[name][0]), found.group
    limits, options = world.limits(group), RefineOptions("trajopt")
    jerk = timing.method == "ruckig"
    request = RefineRequest(
        found.path, limits, world.margins(), options, jerk, motion_limits=others
    )
    curve, _ = refine(world, request, no_hurry())
    if curve is None:
        return np.inf
    motion, _ = retime(curve, limits, timing, path_limits(world, group, timing))
    return motion.duration


@pytest.mark.campaign
@pytest.mark.parametrize("case", list(CASES)[: num_cases(4, len(CASES))])
def test_a_plan_is_proven_and_quicker(case: str) -> None:
    name, goals, timing = CASES[case]
    found = solve(name, goals[name], timing, "trajopt")
    assert found.certificate.proven
    assert found.stages.refine.improved
    plain = solve(name, goals[name], timing, "none")
    np.testing.assert_array_equal(plain.path.waypoints, found.path.waypoints)
    quickest = min(plain.trajectory.duration, refined(found, name, timing, MotionLimits()))
    # Under jerk limits the path itself is followed nearly as quickly.
    gain = 0.99 if timing is RUCKIG else 0.98
    assert found.stages.refine.lower_bound < found.trajectory.duration < gain * quickest


def test_a_way_on_which_gravity_is_too_much_is_left_for_one_on_which_it_is_not() -> None:
    goal = [-0.56, -1.54, 2.28, 0.26, -1.25, -0.61]
    with pytest.raises(RetimingFailed, match="static torque"):
        solve("ur5e", goal, carrying("ur5e", 9.0), "none")
    found = solve("ur5e", goal, carrying("ur5e", 9.0), "trajopt")
    assert found.certificate.proven
    assert next(c for c in found.certificate.checks if c.name == "torque").value <= 1
