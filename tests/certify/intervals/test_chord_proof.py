"""Constraints with a small margin are proven, small violations are refused, at small cost."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

import planning
from planning.certify.constraint_checks import constraint_checks
from planning.certify.frames import frame_poses
from planning.certify.frames.frame_checks import box_check
from planning.domain.geometry.pose import Pose
from planning.domain.request.constraint import (
    KeepIn,
    KeepOut,
    OrientationCone,
    PlacedBox,
    PositionBand,
)
from planning.errors import ProblemInvalid
from tests.certify.conftest import quintic, request_for, world_from
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.profiles import num_cases

TCP = "arm::tcp"
# Margins or violations of constraints: far smaller than any step of a search.
LITTLE = 2e-5


def random_motion(seed: int):
    world = bundled_world("ur5e_pickup")
    rng = np.random.default_rng(seed)
    q0 = world.positions(world.group("arm"))
    q1 = q0 + rng.normal(0.0, 0.6, 6)
    return world, request_for(world, "arm", quintic(world.group("arm"), q0, q1, 2.0))


def poses_along(world, request) -> np.ndarray:
    qs = request.trajectory.positions(np.linspace(0.0, request.trajectory.duration, 6001))
    return world.frame_poses(TCP, world.embed(request.group, qs))


def constraints_around(poses: np.ndarray, rng: np.random.Generator, spare: float) -> list:
    """Return constraints that the motion keeps by the margin `spare`, or violates if negative."""
    axis, direction = (x / np.linalg.norm(x) for x in rng.normal(size=(2, 3)))
    angle = float(np.arccos(np.clip(poses[:, :3, :3] @ axis @ direction, -1, 1)).max())
    middle = Pose.from_parts(poses[2000, :3, 3] + rng.normal(0, 0.15, 3), rpy=rng.normal(size=3))
    local = np.abs((poses[:, :3, 3] - middle.position) @ middle.matrix[:3, :3])
    # The nearest face may change between two samples, so that the minimum is a corner there.
    origins = CubicSpline(np.arange(len(poses)), poses[:, :3, 3])
    dense = origins(np.linspace(0, len(poses) - 1, 100 * len(poses)))
    inner = np.abs((dense - middle.position) @ middle.matrix[:3, :3]).max(axis=1).min()
    outer = local.max()
    found = [
        OrientationCone(TCP, axis, direction, min(angle + spare, np.pi)),
        KeepIn(TCP, PlacedBox(np.full(3, 2 * (outer + spare)), middle)),
        PositionBand(TCP, PlacedBox(2 * (local.max(axis=0) + spare), middle)),
    ]
    if inner > 1e-3:
        found.append(KeepOut(TCP, PlacedBox(np.full(3, 2 * (inner - spare)), middle)))
    return found


@settings(max_examples=num_cases(5))
@given(seed=st.integers(0, 10_000))
def test_a_small_margin_is_proven_and_a_small_violation_is_refused(seed: int) -> None:
    world, request = random_motion(seed)
    poses, verdicts = poses_along(world, request), []
    for spare in (LITTLE, -LITTLE):
        changed = replace(
            request,
            constraints=tuple(constraints_around(poses, np.random.default_rng(seed), spare)),
        )
        checks = constraint_checks(world.drake, changed, no_hurry())
        verdicts.append([check.passed for check in checks])
        for check in checks:
            assert (check.value <= check.bound + 1e-6) == check.passed
    assert all(verdicts[0])
    assert not any(verdicts[1])


def test_the_largest_value_is_known_within_its_resolution() -> None:
    world, request = random_motion(3)
    poses = poses_along(world, request)
    # Beyond a box's corner the distance is not the largest of those along its axes: no keep_out.
    for constraint in constraints_around(poses, np.random.default_rng(3), 0.01)[:3]:
        (check,) = constraint_checks(
            world.drake, replace(request, constraints=(constraint,)), no_hurry()
        )
        truth = check.bound - 0.01
        assert check.value <= truth + 1e-6
        assert check.value + check.resolution >= truth - 1e-6
        assert check.resolution <= max(0.021 * abs(check.bound), 1.1e-4)


def test_a_tight_proof_takes_few_instants(monkeypatch: pytest.MonkeyPatch) -> None:
    """A first-order bound would need 1e5 instants."""
    num_evaluated = []
    places = frame_poses.FramePoses.at

    def counted(self, pieces, local, deadline):
        num_evaluated.append(len(local))
        return places(self, pieces, local, deadline)

    monkeypatch.setattr(frame_poses.FramePoses, "at", counted)
    world, request = random_motion(1)
    (_, constraint, *_) = constraints_around(
        poses_along(world, request), np.random.default_rng(1), LITTLE
    )
    check = box_check("c", constraint, world.drake, request, no_hurry())
    assert check.passed
    assert sum(num_evaluated) < 8_000


def test_a_cone_of_half_a_turn_contains_all_directions() -> None:
    world, request = random_motion(2)
    cone = OrientationCone(TCP, np.eye(3)[0], np.eye(3)[1], np.pi)
    (check,) = constraint_checks(world.drake, replace(request, constraints=(cone,)), no_hurry())
    assert check.passed
    assert 0 < check.value <= np.pi


def test_a_band_between_static_bodies_is_refused_by_name() -> None:
    """It raised an error of numpy once (HTTP 500)."""
    world = world_from("""
robots: [{name: arm, model: ur5e}]
objects:
  - {name: o, shape: {box: [0.1, 0.1, 0.1]}, pose: {position: [2, 2, 2]}}
  - {name: p, shape: {box: [0.1, 0.1, 0.1]}, pose: {position: [2, 3, 2]}}
""")
    home = world.positions(world.group("arm"))
    motion = quintic(world.group("arm"), home, home + 0.05, 3.0)
    band = planning.DistanceBand(("o",), ("p",), 0.01, 5.0)
    with pytest.raises(ProblemInvalid, match=r"path_constraints\.0: no pair") as caught:
        planning.certify_trajectory(world, "arm", motion, deadline=no_hurry(), constraints=(band,))
    assert caught.value.evidence["field"] == "path_constraints.0"
