"""The kernel's motion of a frame's origin is Drake's, on every instruction set."""

from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from pydrake.geometry import Sphere

from planning.certify.frames.frame_states import FrameStates
from planning.certify.frames.kernel_points import KernelPoints
from planning.domain.robot.joints import JointType
from planning.kernel.native import native
from planning.world.collision.margins import PairMargins
from tests.certify.chains import (
    FLOATING,
    PLANAR,
    Builder,
    R,
    random_robot,
    random_trajectory,
)
from tests.certify.oracles import without_kernel
from tests.clocks import no_hurry
from tests.kernel.test_kinematics import with_frames, with_mimics
from tests.profiles import num_cases

pytestmark = pytest.mark.skipif(native() is None, reason="the native kernel is not built")


def made_up(seed: int) -> tuple[Any, Any, str]:
    """A robot's model without masses, the request of a motion, and a frame on one of its links."""
    rng = np.random.default_rng(seed)
    robot = with_frames(random_robot(rng, int(rng.integers(1, 7)), 0))
    if rng.random() < 0.5:
        robot = with_mimics(robot, rng)
    assume(robot.group.joints)
    trajectory = random_trajectory(rng, robot.group, 3, spread=1.0)
    frame = f"robot::link{int(rng.integers(len(robot.model.bodies)))}"
    return robot.model, robot.request(trajectory, PairMargins(0.0, {}, {})), frame


def instants(seed: int, request: Any) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    pieces = rng.integers(0, 3, int(rng.integers(1, 20)))
    return pieces, rng.uniform(0, 1, len(pieces)) * np.diff(request.trajectory.breaks)[pieces]


@settings(max_examples=num_cases(40))
@given(seed=st.integers(0, 2**32 - 1))
def test_positions_velocities_and_accelerations_are_drakes(seed: int) -> None:
    model, request, frame = made_up(seed)
    pieces, local = instants(seed, request)
    found, expected = (
        FrameStates(each, request, frame).at(pieces, local, no_hurry()).parts
        for each in (model, without_kernel(model))
    )
    for part, wanted in zip(found, expected, strict=True):
        scale = 1 + np.abs(wanted).max()
        np.testing.assert_allclose(part, wanted, rtol=0, atol=1e-11 * scale)


@settings(max_examples=num_cases(20))
@given(seed=st.integers(0, 2**32 - 1))
def test_every_instruction_set_gives_the_same_bytes(seed: int) -> None:
    module: Any = native()
    model, request, frame = made_up(seed)
    points = KernelPoints.of(model, request, frame)
    assume(points is not None)
    assert points is not None
    where = instants(seed, request)
    found = {name: points.at(*where, name).tobytes() for name in module.batch_kernels()}
    assert set(found.values()) == {found["base"]}


@pytest.mark.parametrize(("kind", "is_left"), [(R, False), (PLANAR, False), (FLOATING, True)])
def test_frames_behind_joints_that_float_are_left_to_drake(kind: JointType, is_left: bool) -> None:
    builder = Builder()
    builder.link(kind, Sphere(0.1))
    robot = with_frames(builder.build())
    trajectory = random_trajectory(np.random.default_rng(1), robot.group, 1, spread=0.1)
    request = robot.request(trajectory, PairMargins(0.0, {}, {}))
    assert (KernelPoints.of(robot.model, request, "robot::link0") is None) is is_left
    assert KernelPoints.of(without_kernel(robot.model), request, "robot::link0") is None
