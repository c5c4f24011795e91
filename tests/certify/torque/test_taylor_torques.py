"""Torques as polynomials, against Drake's inverse dynamics of robots of any kind."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from pydrake.multibody.tree import MultibodyForces

from planning.certify.torque.links import links_of
from planning.certify.torque.newton_euler import TERMS
from planning.certify.torque.taylor_torques import torque_series
from planning.domain.curves.curve import TimedTrajectory
from planning.domain.robot.joints import JointType
from planning.world.collision.margins import PairMargins
from tests.certify.chains import Robot, random_robot, random_trajectory

GRAVITY = np.array([0.0, 0.0, -9.81])


def drake_efforts(robot: Robot, trajectory: TimedTrajectory, times: np.ndarray) -> np.ndarray:
    """Return the generalized forces by Drake, with those of followers added to their leaders."""
    model, plant = robot.model, robot.model.plant
    context, forces = plant.CreateDefaultContext(), MultibodyForces(plant)
    own = model.velocity_indices(robot.group)
    rates = np.zeros((2, len(times), plant.num_velocities()))
    rates[0][:, own] = trajectory.velocities(times)
    rates[1][:, own] = trajectory.accelerations(times)
    for follower, leader, multiplier in model.mimics:
        rates[:, :, follower] = multiplier * rates[:, :, leader]
    found = np.empty((len(times), plant.num_velocities()))
    full = model.embed(robot.group, trajectory.positions(times), robot.state)
    for i, q in enumerate(full):
        plant.SetPositions(context, q)
        plant.SetVelocities(context, rates[0, i])
        plant.CalcForceElementsContribution(context, forces)
        found[i] = plant.CalcInverseDynamics(context, rates[1, i], forces)
    for follower, leader, multiplier in model.mimics:
        found[:, leader] += multiplier * found[:, follower]
    return found[:, own]


@given(seed=st.integers(0, 10_000), num_links=st.integers(1, 6))
def test_series_agree_with_drakes_torques_within_their_error_bounds(
    seed: int, num_links: int
) -> None:
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, num_links, 0, mass=float(rng.uniform(0.1, 3.0)))
    trajectory = random_trajectory(rng, robot.group, 2, spread=0.5)
    request = robot.request(trajectory, PairMargins(0.0, {}, {}))
    links = links_of(robot.model, request)
    width = float(rng.uniform(0.002, 0.03))
    pieces = np.array([0, 1, 1])
    middles = np.array([0.1, 0.05, 1.1 * width])
    halves = np.full(3, width)
    found = torque_series(links, GRAVITY, trajectory, (pieces, middles, halves))
    scale = 1e-9 * (1 + np.abs(found.taylor[:, 0]).max())
    for share in (-1.0, -0.6, 0.0, 0.3, 1.0):
        times = trajectory.breaks[pieces] + middles + share * halves
        expected = drake_efforts(robot, trajectory, times)
        powers = (share * width) ** np.arange(TERMS)
        got = np.einsum("k,nkv->nv", powers, found.taylor)
        begin = 0
        for joint in robot.group.joints:
            for _, indices in joint.blocks:
                block = [begin + i for i in indices]
                missed = np.linalg.norm(found.errors[:, block], axis=1) + scale
                if joint.type is JointType.FLOATING and indices[0] == 0:
                    # In the world's axes here, in the parent's there: the length is the same.
                    away = np.abs(
                        np.linalg.norm(got[:, block], axis=1)
                        - np.linalg.norm(expected[:, block], axis=1)
                    )
                else:
                    away = np.linalg.norm(got[:, block] - expected[:, block], axis=1)
                assert (away <= missed).all()
            begin += joint.num_velocities


def test_the_error_bound_falls_with_the_fifth_power_of_the_width() -> None:
    rng = np.random.default_rng(5)
    robot = random_robot(rng, 4, 0, mass=1.0)
    trajectory = random_trajectory(rng, robot.group, 1, spread=0.5)
    links = links_of(robot.model, robot.request(trajectory, PairMargins(0.0, {}, {})))
    missed = [
        torque_series(
            links, GRAVITY, trajectory, (np.array([0]), np.array([0.1]), np.array([half]))
        ).errors.max()
        for half in (2e-3, 1e-3)
    ]
    assert missed[0] / missed[1] == np.clip(missed[0] / missed[1], 30, 34)
