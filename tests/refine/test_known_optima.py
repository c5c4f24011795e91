"""Both methods meet optima that are known in closed form."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.path import JointPath
from planning.domain.request.options import RefineOptions
from planning.domain.request.refine_objective import RefineObjective
from planning.refine.constraints.request_bounds import exact_rate_bounds
from planning.refine.drake.program import DrakeProgram
from planning.refine.motion.convex_program import ConvexProgram
from planning.refine.motion.motion_cost import MotionCost
from planning.refine.motion.motion_objectives import MotionObjectives
from planning.refine.motion.motion_program import MotionTask
from planning.refine.motion.spline_motion import SplineMotion
from planning.refine.refine_problem import RefineProblem
from planning.refine.refiner import refine
from planning.refine.request import RefineRequest
from planning.world.documents.scene_file import parse_scene
from planning.world.loading.load_world import load_world
from planning.world.world import World
from tests.clocks import no_hurry

# A point mass of 2 kg at the end of a rod of 0.5 m that hangs down at q = 0.
MASS, LENGTH, GRAVITY = 2.0, 0.5, 9.81
PENDULUM = f"""<robot name="pendulum">
  <link name="base"/>
  <link name="bob"><inertial><origin xyz="0 0 -{LENGTH}"/><mass value="{MASS}"/>
    <inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial></link>
  <joint name="q" type="revolute"><parent link="base"/><child link="bob"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" velocity="50" effort="500"/></joint>
</robot>"""
AMPLE = 1e3


@pytest.fixture
def pendulum(tmp_path: Path) -> World:
    file = tmp_path / "pendulum.urdf"
    file.write_text(PENDULUM)
    return load_world(parse_scene({"robots": [{"name": "pendulum", "model": str(file)}]}))


@pytest.fixture(params=["trajopt", "drake"])
def method(request: pytest.FixtureRequest) -> str:
    return request.param


def swing(
    world: World, method: str, distance: float, objective: RefineObjective, **limits: float
) -> RefineRequest:
    """Return the request for a swing from rest at 0; limits are ample unless given."""
    path = JointPath(world.group("pendulum"), np.array([[0.0], [distance]]))
    rates = {"velocity": AMPLE, "acceleration": AMPLE, "jerk": 1e6, **limits}
    bounds = {name: np.array([value]) for name, value in rates.items()}
    options = RefineOptions(method, objective=objective)
    return RefineRequest(
        path, replace(world.limits(path.group), **bounds), world.margins(), options
    )


def optimum(world: World, request: RefineRequest) -> TimedTrajectory:
    curve, report = refine(world, request, no_hurry(60.0))
    assert isinstance(curve, TimedTrajectory), report.reason
    return curve


def test_the_least_acceleration_between_rests_is_a_cubic(pendulum, method):
    objective = RefineObjective(smoothness=1.0, max_duration=2.0)
    curve = optimum(pendulum, swing(pendulum, method, 1.0, objective))
    assert curve.duration == pytest.approx(2.0, rel=1e-6)
    s = np.linspace(0.0, 1.0, 101)
    np.testing.assert_allclose(curve.positions(2.0 * s)[:, 0], 3 * s**2 - 2 * s**3, atol=1e-3)
    measured = MotionObjectives.of(
        pendulum, pendulum.group("pendulum"), curve, objective, None
    ).values()
    assert measured.smoothness == pytest.approx(12 / 2.0**3, rel=1e-3)


def test_the_least_jerk_between_rests_is_a_quintic(pendulum, method):
    """Flash and Hogan, "The coordination of arm movements", 1985: 720 d^2 / T^5."""
    objective = RefineObjective(smoothness=1.0, derivative="jerk", max_duration=1.5)
    curve = optimum(pendulum, swing(pendulum, method, 0.8, objective))
    s = np.linspace(0.0, 1.0, 101)
    quintic = 0.8 * (10 * s**3 - 15 * s**4 + 6 * s**5)
    np.testing.assert_allclose(curve.positions(1.5 * s)[:, 0], quintic, atol=2e-3)
    measured = MotionObjectives.of(
        pendulum, pendulum.group("pendulum"), curve, objective, None
    ).values()
    # Jerks of a cubic spline are constant between knots, so that it cannot quite reach the least.
    assert 1.0 <= measured.smoothness / (720 * 0.8**2 / 1.5**5) < 1.02


def test_the_least_duration_of_one_joint_is_bang_bang(pendulum, method):
    """2 sqrt(d / a). The refiner leaves a straight path alone: this asks the program itself."""
    request = swing(pendulum, method, 1.0, RefineObjective(duration=1.0), acceleration=4.0)
    problem = RefineProblem.of(pendulum, request, no_hurry(60.0))
    cost = MotionCost(request.options.objective, None, 24)
    task = MotionTask(problem, exact_rate_bounds(request, ()), cost, 2)
    drake = DrakeProgram(task, pendulum.drake.plant)
    program = drake if method == "drake" else ConvexProgram(task)
    guess = SplineMotion(np.linspace(0.0, 1.0, 24)[:, None], 3.0)
    solution = program.solve(guess.with_ends_of(problem.waypoints, 2), np.array([0.5]))
    assert solution.ending == ""
    assert 1.0 <= solution.motion.duration < 1.01


def test_the_least_energy_of_a_small_swing_is_that_of_the_linear_pendulum(pendulum, method):
    """With tau = m l^2 (q'' + w^2 q) the least integral of tau^2 solves (D^2 + w^2)^2 q = 0."""
    duration, distance, omega = 1.2, 0.04, np.sqrt(GRAVITY / LENGTH)
    objective = RefineObjective(energy=1.0, max_duration=duration)
    request = swing(pendulum, method, distance, objective)
    # The duration as well: the program may choose a shorter one.
    curve = optimum(pendulum, request)
    t_end = curve.duration
    c, s = np.cos(omega * t_end), np.sin(omega * t_end)
    # q = (a + b t) cos + (d + e t) sin, from rest at 0 to rest at `distance`.
    rows = [
        [1, 0, 0, 0],
        [0, 1, omega, 0],
        [c, t_end * c, s, t_end * s],
        [-omega * s, c - omega * t_end * s, omega * c, s + omega * t_end * c],
    ]
    a, b, d, e = np.linalg.solve(np.array(rows), [0.0, 0.0, distance, 0.0])
    t = np.linspace(0.0, t_end, 101)
    exact = (a + b * t) * np.cos(omega * t) + (d + e * t) * np.sin(omega * t)
    np.testing.assert_allclose(curve.positions(t)[:, 0], exact, atol=0.02 * distance)
