"""Contenders: each times a path in its usual way, under the same limits."""

from collections.abc import Callable
from functools import cache, partial
from itertools import pairwise
from typing import Any

import numpy as np
import ruckig
from pydrake.multibody.optimization import CalcGridPointsOptions, Toppra
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RevoluteJoint, SpatialInertia
from pydrake.polynomial import Polynomial
from pydrake.trajectories import PiecewisePolynomial
from toppra import SplineInterpolator
from toppra.algorithm import TOPPRA
from toppra.constraint import JointAccelerationConstraint, JointVelocityConstraint

from benchmarks.retiming.motion import Array, Motion
from benchmarks.retiming.paths import Question
from planning.domain.curves.curve import JointSpline, TimedTrajectory
from planning.domain.request.options import RetimeOptions
from planning.retime.blend import blend_corners
from planning.retime.retimer import RETIMERS, retime

# Takes a question in, in its own terms, and returns what is timed.
type Contender = Callable[[Question], Callable[[], Motion | None]]

# How far our corners may be rounded (joint-space length), as the pipeline does it.
ROUNDED = 0.1
_CYCLE = 0.01


def ours(method: str, deviation: float) -> Contender:
    """Return our retiming of the path with its corners rounded by so much."""

    def run(question: Question) -> Motion:
        spline = blend_corners(question.path, deviation, RETIMERS[method].smoothness)
        options = RetimeOptions("ruckig" if method == "ruckig" else "toppra")
        return _of_ours(retime(spline, question.limits, options)[0])

    return lambda question: partial(run, question)


def plain_toppra(question: Question) -> Motion | None:
    """Return toppra's answer along its cubic spline, as its documentation shows it."""
    waypoints, limits = question.path.waypoints, question.limits
    spline = SplineInterpolator(np.linspace(0, 1, len(waypoints)), waypoints)
    both = [
        JointVelocityConstraint(np.stack([-limits.velocity, limits.velocity], axis=1)),
        JointAccelerationConstraint(np.stack([-limits.acceleration, limits.acceleration], axis=1)),
    ]
    found: Any = TOPPRA(both, spline, solver_wrapper="seidel").compute_trajectory(0, 0)
    if found is None:
        return None
    return Motion(float(found.duration), lambda t: [np.array(found(t, k)) for k in range(3)])


def drake_on_spline(question: Question) -> Motion | None:
    """Return the answer of Drake's Toppra along the cubic spline through the waypoints."""
    waypoints = question.path.waypoints
    zero = np.zeros(waypoints.shape[1])
    path = PiecewisePolynomial.CubicWithContinuousSecondDerivatives(
        np.linspace(0, 1, len(waypoints)), waypoints.T, zero, zero
    )
    return _by_drake(path, question, np.zeros(0))


def drake_on_ours(question: Question) -> Callable[[], Motion | None]:
    """Return what finds the answer of Drake's Toppra along our own rounded path."""
    spline = blend_corners(question.path, ROUNDED, 1)
    return partial(_by_drake, _as_drake(spline), question, spline.breaks)


def ruckig_at_rest(question: Question) -> Motion | None:
    """Return ruckig's motions from waypoint to waypoint, state to state, at rest at each."""
    waypoints, limits = question.path.waypoints, question.limits
    count = waypoints.shape[1]
    generator, legs = ruckig.Ruckig(count, _CYCLE), list[Any]()
    wanted = ruckig.InputParameter(count)
    wanted.max_velocity, wanted.max_acceleration, wanted.max_jerk = (
        bound.tolist() for bound in (limits.velocity, limits.acceleration, limits.jerk)
    )
    for begin, end in pairwise(waypoints):
        wanted.current_position, wanted.target_position = begin.tolist(), end.tolist()
        legs.append(ruckig.Trajectory(count))
        if int(generator.calculate(wanted, legs[-1])) < 0:
            return None
    ends = np.cumsum([leg.duration for leg in legs])
    return Motion(float(ends[-1]), lambda t: _of_legs(legs, ends, t))


CONTENDERS: dict[str, Contender] = {
    "ours, toppra": ours("toppra", ROUNDED),
    "ours, toppra, corners kept": ours("toppra", 0.0),
    "toppra, its spline": lambda question: partial(plain_toppra, question),
    "Drake Toppra, cubic spline": lambda question: partial(drake_on_spline, question),
    "Drake Toppra, our path": drake_on_ours,
    "ours, ruckig": ours("ruckig", ROUNDED),
    "ours, ruckig, corners kept": ours("ruckig", 0.0),
    "ruckig, rests at waypoints": lambda question: partial(ruckig_at_rest, question),
}
# Whose limits on jerk count, and whose durations are compared with those.
JERK = {name for name in CONTENDERS if "ruckig" in name}
YARDSTICKS = {name: "ours, ruckig" if name in JERK else "ours, toppra" for name in CONTENDERS}


def _of_ours(trajectory: TimedTrajectory) -> Motion:
    return Motion(
        trajectory.duration,
        lambda t: [trajectory.positions(t), *(trajectory.tangents(t, k) for k in (1, 2, 3))],
    )


def _by_drake(path: Any, question: Question, breaks: Array) -> Motion | None:
    """Solve on the grid that Drake proposes, with the path's own breaks in it."""
    grid = Toppra.CalcGridPoints(path, CalcGridPointsOptions())
    problem = Toppra(path, _chain(path.rows()), np.unique([*grid, *breaks]))
    limits = question.limits
    problem.AddJointVelocityLimit(-limits.velocity, limits.velocity)
    problem.AddJointAccelerationLimit(-limits.acceleration, limits.acceleration)
    timing: Any = problem.SolvePathParameterization()
    if timing is None:
        return None

    def sample(times: Array) -> list[Array]:
        s, rate, change = (
            np.ravel(derivative.vector_values(times))
            for derivative in (timing, timing.derivative(1), timing.derivative(2))
        )
        s = np.clip(s, path.start_time(), path.end_time())
        r0, r1, r2 = (path.derivative(k).vector_values(s).T for k in range(3))
        return [r0, r1 * rate[:, None], r2 * rate[:, None] ** 2 + r1 * change[:, None]]

    return Motion(float(timing.end_time()), sample)


@cache
def _chain(count: int) -> MultibodyPlant:
    """Return a robot of so many joints; without torque limits nothing else matters of it."""
    plant = MultibodyPlant(0.0)
    above = plant.world_body()
    for i in range(count):
        link = plant.AddRigidBody(f"link{i}", SpatialInertia.SolidSphereWithMass(1.0, 0.1))
        frames = above.body_frame(), link.body_frame()
        plant.AddJoint(RevoluteJoint(f"joint{i}", *frames, np.array([0.0, 0.0, 1.0])))
        above = link
    plant.Finalize()
    return plant


def _as_drake(spline: JointSpline) -> PiecewisePolynomial:
    coefficients = np.array(spline.coefficients)
    coefficients[:, 0] += spline.bases
    pieces = [
        np.array([[Polynomial(column)] for column in piece.T], dtype=object)
        for piece in coefficients
    ]
    return PiecewisePolynomial(pieces, spline.breaks)


def _of_legs(legs: list[Any], ends: Array, times: Array) -> list[Array]:
    which = np.minimum(np.searchsorted(ends, times), len(legs) - 1)
    begins = np.concatenate([[0.0], ends[:-1]])
    rows = [legs[i].at_time(t - begins[i]) for i, t in zip(which, times, strict=True)]
    return [np.array([row[k] for row in rows]) for k in range(3)]
