"""Joint efforts: held against energy, and against what is known of a pendulum."""

import numpy as np
import pytest

import planning
from planning.api.motion_series import motion_series
from planning.domain.curves.interpolation import trajectory_through
from planning.domain.robot.joints import JointGroup
from planning.world.mechanics.dynamics import GroupDynamics
from planning.world.world import World
from tests.conftest import bundled_world


def potential(world: World, group: JointGroup, q: np.ndarray) -> float:
    """Return m g z of all that belongs to the group's robot [J]."""
    model = world.drake
    context = model.plant.CreateDefaultContext()
    model.plant.SetPositions(context, world.embed(group, q))
    robot = [model.plant.get_joint(model.joint_indices[group.joints[0].name]).model_instance()]
    height = model.plant.CalcCenterOfMassPositionInWorld(context, robot)[2]
    return 9.81 * model.plant.CalcTotalMass(context, robot) * height


@pytest.mark.parametrize(("scene", "name"), [("ur5e_pickup", "arm"), ("panda_shelf", "panda")])
def test_the_work_that_efforts_do_is_the_gain_of_energy(scene: str, name: str) -> None:
    """Of the energy at rest: potential energy is what is left of the work."""
    world = bundled_world(scene)
    group = world.group(name)
    q0 = world.positions(group)
    q1 = q0 + 0.3 * np.where(np.arange(len(q0)) % 2, 1, -1)
    motion = trajectory_through(
        group.joints, np.array([0.0, 0.4, 1.0]), np.array([q0, q1, q0 - 0.1])
    )
    times = np.linspace(0.0, motion.duration, 401)
    q, v = motion.positions(times), motion.velocities(times)
    efforts = GroupDynamics(world, group).efforts(q, v, motion.accelerations(times))
    work = float(np.trapezoid((efforts * v).sum(axis=1), times))
    gained = potential(world, group, q[-1]) - potential(world, group, q[0])
    assert work == pytest.approx(gained, abs=2e-3 * np.abs(work) + 2e-3)
    assert np.abs(efforts * v).max() > 1


def test_at_rest_efforts_are_the_slope_of_potential_energy() -> None:
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    q, step = world.positions(group), 1e-5
    still = np.zeros((1, group.num_velocities))
    held = GroupDynamics(world, group).efforts(q[None], still, still)[0]
    slopes = [
        (potential(world, group, q + step * e) - potential(world, group, q - step * e)) / (2 * step)
        for e in np.eye(len(q))
    ]
    np.testing.assert_allclose(held, slopes, atol=1e-5)


def test_series_agree_with_the_motion_and_its_certificate() -> None:
    world = bundled_world("ur5e_pickup")
    group = world.group("arm")
    home = world.positions(group)
    timed = planning.retime_path(
        world,
        "arm",
        np.array([home, home + np.array([0.2, 0.1, 0.0, 0.1, 0.0, 0.3])]),
        deadline=planning.Deadline.after(20.0, _no_time),
    )
    series = motion_series(world, "arm", timed.trajectory, 101)
    assert series.clearance.min() >= timed.certificate.min_clearance - 1e-3
    used = series.utilisation
    for rate, peak in timed.retime.utilisation.items():
        assert used[rate].max() <= peak + 1e-9
        assert used[rate].max() > 0.9 * peak
    assert 0 < used["torque"].max() < 1
    assert all(series.closest_pairs[int(series.clearance.argmin())])


def _no_time() -> float:
    return 0.0
