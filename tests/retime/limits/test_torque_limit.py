"""Timing under torque limits: known optima, gravity that does not slow down, payloads."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from pydrake.multibody.tree import JacobianWrtVariable

from planning.domain.curves.curve import TimedTrajectory
from planning.domain.curves.path import JointPath
from planning.domain.report.stage_reports import RetimeReport
from planning.domain.request.options import RetimeOptions
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.payload import Payload
from planning.errors import ProblemInvalid, RetimingFailed, UnknownName
from planning.retime.blend import blend_corners
from planning.retime.limits.request_limits import path_limits
from planning.retime.retimer import RETIMERS, retime
from planning.world.world import World
from tests.conftest import bundled_world
from tests.profiles import num_cases

# A point mass of 2 kg on a rod of 0.5 m, and a cart of 3 kg on a vertical slide.
PENDULUM = """<robot name="p"><link name="base"/><link name="bob"><inertial>
<origin xyz="0 0 -0.5"/><mass value="2"/>
<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="swing" type="revolute"><parent link="base"/><child link="bob"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" velocity="100" effort="{effort}"/></joint></robot>"""
LIFT = """<robot name="s"><link name="base"/><link name="cart"><inertial>
<mass value="3"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="lift" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" velocity="9" effort="200"/><dynamics damping="{damping}"/></joint>
</robot>"""
MGL, INERTIA = 2 * 9.81 * 0.5, 2 * 0.5**2
ARMS = {"ur5e": ("ur5e_pickup", "arm", 4.0), "panda": ("panda_shelf", "panda", 5.0)}


def timed(
    world: World, name: str, waypoints: np.ndarray, options: RetimeOptions, deviation: float = 0.1
) -> tuple[TimedTrajectory, RetimeReport]:
    group = world.group(name)
    smoothness = RETIMERS[options.method].smoothness
    spline = blend_corners(JointPath(group, waypoints), deviation, smoothness)
    return retime(spline, world.limits(group), options, path_limits(world, group, options))


def arm_path(world: World, group: JointGroup, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    q = world.positions(group)
    return np.stack([q, *(q + rng.normal(0.0, 0.4, (2, len(q))))])


def independent_efforts(
    world: World, group: JointGroup, motion: TimedTrajectory, times: np.ndarray, payload: Payload
) -> np.ndarray:
    """Return M vdot + C v - tau_g with the payload, shape (m, nv).

    By Drake's mass matrix, bias and gravity, and a payload as a point mass by virtual work.
    """
    plant = world.drake.plant
    context, world_frame = plant.CreateDefaultContext(), plant.world_frame()
    own = world.drake.velocity_indices(group)
    q = world.embed(group, motion.positions(times))
    v, vdot = np.zeros((2, len(times), plant.num_velocities()))
    v[:, own], vdot[:, own] = motion.velocities(times), motion.accelerations(times)
    frame, point = world.drake.frames[payload.frame], payload.center_of_mass
    found = np.empty_like(v)
    for i in range(len(times)):
        plant.SetPositions(context, q[i])
        plant.SetVelocities(context, v[i])
        inertia = plant.CalcMassMatrix(context)
        own_part = inertia @ vdot[i] + plant.CalcBiasTerm(context)
        own_part -= plant.CalcGravityGeneralizedForces(context)
        how = (context, JacobianWrtVariable.kV, frame, point, world_frame, world_frame)
        jacobian = plant.CalcJacobianTranslationalVelocity(*how)
        bias = plant.CalcBiasTranslationalAcceleration(*how)
        pull = payload.mass * (jacobian @ vdot[i] + bias.ravel() + np.array([0.0, 0.0, 9.81]))
        found[i] = own_part + jacobian.T @ pull
    return found[:, own]


def least_time(low: float, high: float, effort: float) -> float:
    """Return the least time of a pendulum's swing: full torque one way, then the other."""

    def work(q: np.ndarray, begin: float, sign: float) -> np.ndarray:
        return sign * effort * (q - begin) + MGL * (np.cos(q) - np.cos(begin))

    switch = (low + high) / 2 + MGL * (np.cos(low) - np.cos(high)) / (2 * effort)
    total = 0.0
    for end in (low, high):
        # q = end + (switch - end) y^2 takes away the square root's pole at rest.
        y = (np.arange(4000) + 0.5) / 4000
        q = end + (switch - end) * y**2
        speed = np.sqrt(2 / INERTIA * work(q, end, 1.0 if end == low else -1.0))
        total += float(np.mean(2 * abs(switch - end) * y / speed))
    return total


@pytest.mark.parametrize(("low", "high"), [(-1.0, 1.2), (-0.4, 0.3), (2.0, -2.5)])
def test_a_pendulum_swings_in_the_least_time_of_its_torque(
    urdf_world: Callable[..., World], low: float, high: float
) -> None:
    world = urdf_world(PENDULUM.format(effort=12))
    options = RetimeOptions(effort=True)
    motion, report = timed(world, "r", np.array([[low], [high]]), options)
    least = least_time(min(low, high), max(low, high), 12.0)
    assert least <= motion.duration <= 1.02 * least
    assert 0.99 < report.utilisation["torque"] <= 1
    assert report.binding["torque"] == "r::swing"
    times = np.linspace(0, motion.duration, 1001)[1:-1]
    q, vdot = motion.positions(times)[:, 0], motion.accelerations(times)[:, 0]
    used = np.abs(INERTIA * vdot + MGL * np.sin(q)) / 12
    assert used.max() <= 1
    assert (used > 0.95).mean() > 0.9


@pytest.mark.parametrize("method", sorted(RETIMERS))
def test_a_swing_whose_static_torque_exceeds_its_limit_is_refused(
    urdf_world: Callable[..., World], method: str
) -> None:
    world = urdf_world(PENDULUM.format(effort=9))
    options = RetimeOptions(method=method, effort=True)
    with pytest.raises(RetimingFailed) as refusal:
        timed(world, "r", np.array([[0.0], [2.5]]), options)
    evidence = refusal.value.evidence
    assert evidence["where"] == "r::swing"
    assert evidence["torque"] == pytest.approx(MGL, rel=0.02)
    assert evidence["bound"] == pytest.approx(9, rel=0.02)
    timed(world, "r", np.array([[0.0], [1.0]]), options)  # as far as it can be held


@pytest.mark.parametrize("carried", [0.0, 4.0, 10.0])
def test_a_lift_takes_the_least_time_of_its_force(
    urdf_world: Callable[..., World], carried: float
) -> None:
    world = urdf_world(LIFT.format(damping=0))
    payload = Payload.from_parts("r::cart", carried) if carried else None
    options = RetimeOptions(effort=True, payload=payload)
    motion, _ = timed(world, "r", np.array([[0.0], [0.5]]), options)
    most = float(world.limits(world.group("r")).acceleration[0])
    up, down = min(most, 200 / (3 + carried) - 9.81), min(most, 200 / (3 + carried) + 9.81)
    least = np.sqrt(2 * 0.5 / (1 / up + 1 / down)) * (1 / up + 1 / down)
    assert least * (1 - 1e-9) <= motion.duration <= 1.015 * least


def test_damping_takes_its_share_of_the_force(urdf_world: Callable[..., World]) -> None:
    world = urdf_world(LIFT.format(damping=60))
    motion, report = timed(world, "r", np.array([[0.0], [2.0]]), RetimeOptions(effort=True))
    times = np.linspace(0, motion.duration, 2001)
    v, vdot = motion.velocities(times)[:, 0], motion.accelerations(times)[:, 0]
    force = np.abs(3 * (vdot + 9.81) + 60 * v).max()
    assert 0.99 * 200 < force <= 200
    assert report.utilisation["torque"] == pytest.approx(force / 200, rel=2e-3)


@pytest.mark.parametrize("method", sorted(RETIMERS))
@pytest.mark.parametrize("name", ARMS)
@settings(max_examples=num_cases(2))
@given(seed=st.integers(0, 1000))
def test_torques_hold_ten_times_finer_by_other_means(name: str, method: str, seed: int) -> None:
    scene, arm, mass = ARMS[name]
    world = bundled_world(scene)
    group = world.group(arm)
    payload = Payload.from_parts(group.tool_frames[0], mass, (0.02, 0.0, 0.05))
    options = RetimeOptions(method=method, effort=True, payload=payload)
    path = arm_path(world, group, seed)
    free, _ = timed(world, arm, path, RetimeOptions(method=method))
    limits = world.limits(group).effort
    # A very slow motion takes the static torques alone.
    crept = free.time_scaled(1e4)
    held = independent_efforts(
        world, group, crept, crept.sample_times(crept.duration / 500), payload
    )
    need = float(np.abs(held / limits).max())
    assume(abs(need - 1) > 0.05)
    if need > 1:
        with pytest.raises(RetimingFailed) as refusal:
            timed(world, arm, path, options)
        assert refusal.value.evidence["torque"] > refusal.value.evidence["bound"]
        return
    motion, report = timed(world, arm, path, options)
    times = np.linspace(0, motion.duration, 500)
    efforts = independent_efforts(world, group, motion, times, payload)
    used = np.abs(efforts / limits).max()
    assert used <= 1
    assert used <= report.utilisation["torque"] + 2e-3
    assert motion.duration >= free.duration * (1 - 1e-3)


def test_more_payload_is_never_quicker_and_at_last_too_much() -> None:
    world = bundled_world("panda_shelf")
    group = world.group("panda")
    path = arm_path(world, group, 8)
    durations = []
    for mass in (0.1, 2.0, 4.0, 5.0):
        payload = Payload.from_parts(group.tool_frames[0], mass, (0.0, 0.0, 0.1))
        options = RetimeOptions(effort=True, payload=payload)
        durations.append(timed(world, "panda", path, options)[0].duration)
    assert (np.diff(durations) >= -1e-3).all()
    assert durations[-1] > 1.05 * durations[0]
    payload = Payload.from_parts(group.tool_frames[0], 30.0)
    with pytest.raises(RetimingFailed, match="static torque of"):
        timed(world, "panda", path, RetimeOptions(effort=True, payload=payload))


def test_a_floating_body_keeps_force_and_torque() -> None:
    world = bundled_world("window_3d")
    group = world.group("body")
    q = world.positions(group)
    spline = JointPath(group, np.stack([q, q])).spline
    tangent = np.array([0.6, -0.4, 0.5, 0.2, 0.1, 0.2])
    goal = spline.manifold.plus(q, tangent)
    motion, report = timed(world, "body", np.stack([q, goal]), RetimeOptions(effort=True))
    assert report.utilisation["torque"] <= 1
    assert motion.duration > 0


def test_a_payload_that_burdens_nothing_is_refused() -> None:
    world = bundled_world("panda_shelf")
    with pytest.raises(ProblemInvalid, match="does not move"):
        path_limits(
            world,
            world.group("panda"),
            RetimeOptions(effort=True, payload=Payload.from_parts("panda::panda_link0", 1.0)),
        )
    with pytest.raises(UnknownName):
        path_limits(
            world,
            world.group("panda"),
            RetimeOptions(effort=True, payload=Payload.from_parts("panda::hook", 1.0)),
        )
