"""The kernel's inverse dynamics is Drake's, for every kind of joint, mimics and motors."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from pydrake.geometry import Sphere
from pydrake.multibody.tree import LinearSpringDamper, MultibodyForces

from planning.kernel.native import native
from planning.world.kernel.kernel_dynamics import kernel_dynamics
from tests.certify.chains import FLOATING, Builder, P, R, Robot
from tests.kernel.test_kinematics import made_up
from tests.profiles import num_cases

pytestmark = pytest.mark.skipif(native() is None, reason="the native kernel is not built")
MASS = 2.0


def undamped(robot: Robot) -> Any:
    """A context in which no joint has damping, which the kernel does not have."""
    plant = robot.model.plant
    context = plant.CreateDefaultContext()
    for index in plant.GetJointIndices():
        joint: Any = plant.get_joint(index)
        joint.SetDampingVector(context, np.zeros(joint.num_velocities()))
    return context


def by_drake(robot: Robot, context: Any, q: Any, v: Any, vdot: Any) -> np.ndarray:
    """The efforts of a group whose followers go on its coordinates (virtual work)."""
    model, plant = robot.model, robot.model.plant
    from_group = np.zeros((plant.num_velocities(), robot.group.num_velocities))
    from_group[model.velocity_indices(robot.group), np.arange(from_group.shape[1])] = 1.0
    for c in model.couplings:
        from_group[c.follower_velocity] = c.multiplier * from_group[c.leader_velocity]
    plant.SetPositions(context, model.embed(robot.group, q, robot.state))
    plant.SetVelocities(context, from_group @ v)
    forces = MultibodyForces(plant)
    plant.CalcForceElementsContribution(context, forces)
    return from_group.T @ plant.CalcInverseDynamics(context, from_group @ vdot, forces)


@settings(max_examples=num_cases(60))
@given(seed=st.integers(0, 2**32 - 1))
def test_efforts_are_those_of_drake(seed: int) -> None:
    robot, _, qs = made_up(seed, MASS)
    rng, context = np.random.default_rng(seed), undamped(robot)
    v, vdot = rng.normal(0.0, 3.0, (2, len(qs), robot.group.num_velocities))
    dynamics = kernel_dynamics(robot.model, robot.group, robot.state, context)
    assert dynamics is not None
    found = dynamics.efforts(qs, v, vdot)
    for i in range(len(qs)):
        expected = by_drake(robot, context, qs[i], v[i], vdot[i])
        scale = max(1.0, float(np.abs(expected).max(initial=0.0)))
        np.testing.assert_allclose(found[i], expected, rtol=0, atol=1e-11 * scale)


@settings(max_examples=num_cases(30))
@given(seed=st.integers(0, 2**32 - 1))
def test_derivatives_are_those_of_efforts(seed: int) -> None:
    robot, _, qs = made_up(seed, MASS)
    assume(all(joint.type is not FLOATING for joint in robot.group.joints))
    rng, context = np.random.default_rng(seed), undamped(robot)
    state = np.stack([qs, *rng.normal(0.0, 3.0, (2, *qs.shape))])
    dynamics = kernel_dynamics(robot.model, robot.group, robot.state, context)
    assert dynamics is not None
    found = dynamics.derivatives(*state)
    # Efforts are quadratic in v and linear in vdot; by q the quotient is of fourth order.
    for part, h in ((0, 1e-3), (1, 1.0), (2, 1.0)):
        for j in range(qs.shape[1]):
            at = dict[int, np.ndarray]()
            for k in (-2, -1, 1, 2):
                shifted = state.copy()
                shifted[part, :, j] += k * h
                at[k] = dynamics.efforts(*shifted)
            expected = (8 * (at[1] - at[-1]) - (at[2] - at[-2])) / (12 * h)
            scale = max(1.0, *(float(np.abs(efforts).max()) for efforts in at.values()))
            atol = 1e-9 * scale if part == 0 else 1e-12 * scale
            np.testing.assert_allclose(found[part, :, :, j], expected, rtol=0, atol=atol)


def test_joints_outside_of_the_group_stay_as_the_state_has_them() -> None:
    robot, _, qs = made_up(5, MASS)
    assert len(robot.group.joints) > 2
    few = replace(robot, group=replace(robot.group, joints=robot.group.joints[1:]))
    model, context = few.model, undamped(few)
    full = model.embed(robot.group, qs[1], robot.state)
    moved = replace(few, state=full)
    v = np.ones((1, few.group.num_velocities))
    q = full[None, model.position_indices(few.group)]
    dynamics = kernel_dynamics(model, few.group, full, context)
    assert dynamics is not None
    expected = by_drake(moved, context, q[0], v[0], 2 * v[0])
    np.testing.assert_allclose(dynamics.efforts(q, v, 2 * v)[0], expected, rtol=0, atol=1e-9)
    other = kernel_dynamics(model, few.group, robot.state, context)
    assert other is not None
    assert np.abs(other.efforts(q, v, 2 * v)[0] - expected).max() > 1e-6


def test_springs_and_bodies_without_mass_are_left_to_drake() -> None:
    for mass, has_spring in ((MASS, False), (MASS, True), (np.nan, False)):
        builder = Builder(mass=mass)
        above = None
        for kind in (R, P):
            above = builder.link(kind, Sphere(0.1), above)
        if has_spring:
            a, b = builder.links
            spring = LinearSpringDamper(a, np.zeros(3), b, np.ones(3), 0.5, 10.0, 1.0)
            builder.plant.AddForceElement(spring)
        robot = builder.build()
        dynamics = kernel_dynamics(robot.model, robot.group, robot.state, undamped(robot))
        assert (dynamics is None) is (has_spring or mass != MASS)
