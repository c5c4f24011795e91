"""Distances of boxes: true everywhere that people and planners ask, though Drake's are not."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RollPitchYaw

import planning
from planning.kernel.box_distance import box_distances, box_gaps
from planning.world.collision.collision_check import DrakeCollisionOracle
from planning.world.kernel.kernel_oracle import KernelCollisionOracle
from planning.world.kernel.kernel_scene import kernel_scene
from planning.world.world import World
from tests.profiles import num_cases

BLOCK = """<robot name="m"><link name="base"/><link name="a"><collision><origin xyz="0 0 0.03"/>
<geometry><box size="0.2 0.05 0.05"/></geometry></collision></link>
<joint name="j" type="planar"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/></joint>
</robot>"""
# Where Drake 1.58 says 60.4 mm and 25.1 mm are true.
POSE = np.array([0.15230923, -0.36251579, 0.02424064])
TRUTH = 0.02506


def least_distance(half_a, X_A, half_b, X_B) -> float:
    """Return the distance by projected gradients: alternating projections with momentum.

    They end where a slab between both boxes is as wide as the distance of the points found.
    """
    R_A, R_B, offset = X_A[:3, :3], X_B[:3, :3], X_A[:3, 3] - X_B[:3, 3]
    x = y = np.zeros(6)
    matrix, half = np.hstack([R_A, -R_B]), np.concatenate([half_a, half_b])
    for k in range(20_000):
        step = y - matrix.T @ (matrix @ y + offset) / 2
        ahead = np.clip(step, -half, half)
        y, x = ahead + k / (k + 3) * (ahead - x), ahead
        if k % 50 == 0:
            away = matrix @ x + offset
            length = np.linalg.norm(away)
            slab = (away @ offset - np.abs(matrix.T @ away) @ half) / max(length, 1e-12)
            if length < 1e-6 or length - slab < 1e-11:
                break
    return float(np.linalg.norm(matrix @ x + offset))


def pose(rng: np.random.Generator, kind: str) -> np.ndarray:
    spread = {"parallel": 0.0, "nearly": 10.0 ** rng.uniform(-9, -1), "any": 3.0}[kind]
    X = np.eye(4)
    X[:3, :3] = RollPitchYaw(rng.uniform(-spread, spread, 3)).ToRotationMatrix().matrix()
    X[:3, 3] = rng.normal(0, 0.3, 3)
    return X


@given(seed=st.integers(0, 10_000), kind=st.sampled_from(["parallel", "nearly", "any"]))
@settings(max_examples=num_cases(6))
def test_distances_of_boxes_are_exact(seed: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    half_a, half_b = rng.uniform(0.01, 0.15, (2, 3))
    X_A, X_B = pose(rng, kind), np.eye(4)
    (distance,), (points,) = box_distances(half_a[None], X_A[None], half_b[None], X_B[None])
    truth = least_distance(half_a, X_A, half_b, X_B)
    if truth > 1e-4:
        assert distance == pytest.approx(truth, abs=1e-6)
        assert np.linalg.norm(points[0] - points[1]) == pytest.approx(distance)


@given(seed=st.integers(0, 10_000), kind=st.sampled_from(["parallel", "nearly", "any"]))
@settings(max_examples=num_cases(8))
def test_gaps_say_whether_boxes_overlap_and_how_deeply(seed: int, kind: str) -> None:
    """Bars that cross have no corner in each other."""
    rng = np.random.default_rng(seed)
    half_a, half_b = 10.0 ** rng.uniform(-2, 0, (2, 3))
    X_A, X_B = pose(rng, kind), np.eye(4)
    (gap,) = box_gaps(half_a[None], X_A[None], half_b[None], X_B[None])
    truth = least_distance(half_a, X_A, half_b, X_B)
    if truth > 1e-4:
        assert 0 < gap <= truth + 1e-9
        return
    assert gap <= 2e-4
    # No direction parts them by less.
    ways = rng.normal(size=(200, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    reach = np.abs(ways @ X_A[:3, :3]) @ half_a + np.abs(ways) @ half_b - ways @ X_A[:3, 3]
    assert -gap <= reach.min() + 1e-12


TINY = """<robot name="m"><link name="base"/><link name="a"><collision><geometry>
<box size="8.8e-5 1.6e-4 1.6e-4"/></geometry></collision></link>
<joint name="j" type="floating"><parent link="base"/><child link="a"/></joint></robot>"""


def test_tiny_boxes_that_overlap_are_not_valid(tmp_path: Path) -> None:
    """Of boxes of a tenth of a millimetre Drake does not always know that they overlap."""
    file = tmp_path / "tiny.urdf"
    file.write_text(TINY)
    still = {"name": "still", "shape": {"box": [4e-5, 1e-4, 1.4e-4]}}
    scene = {"robots": [{"name": "r", "model": str(file)}], "objects": [still]}
    world = planning.load_world(planning.parse_scene(scene))
    rng, deep = np.random.default_rng(0), 0
    for _ in range(60):
        turn = rng.normal(size=4)
        q = np.concatenate([turn / np.linalg.norm(turn), rng.normal(0, 6e-5, 3)])
        (verdict,) = planning.check_configurations(world, "r", q[None])
        X_A = np.eye(4)
        X_A[:3, :3] = Quaternion(wxyz=q[:4] / np.linalg.norm(q[:4])).rotation()
        X_A[:3, 3] = q[4:]
        halves = np.array([[4.4e-5, 8e-5, 8e-5]]), np.array([[2e-5, 5e-5, 7e-5]])
        (gap,) = box_gaps(halves[0], X_A[None], halves[1], np.eye(4)[None])
        assert verdict.valid == (gap > 0)
        deep += gap < -1e-6
    assert deep > 10


def block_world(folder: Path, margin: float) -> World:
    file = folder / "block.urdf"
    file.write_text(BLOCK)
    post = {"shape": {"box": [0.02, 0.1, 0.06]}, "pose": {"position": [0.02, -0.45, 0.03]}}
    scene = {"robots": [{"name": "r", "model": str(file)}], "margin": margin}
    return planning.load_world(
        planning.parse_scene({**scene, "objects": [{"name": "post", **post}]})
    )


def test_a_check_tells_the_true_distance_of_boxes(tmp_path: Path) -> None:
    world = block_world(tmp_path, 0.05)
    (verdict,) = planning.check_configurations(world, "r", POSE[None])
    assert not verdict.valid
    assert verdict.nearest.distance == pytest.approx(TRUTH, abs=1e-5)
    apart = np.diff(verdict.nearest.points, axis=0)
    assert np.linalg.norm(apart) == pytest.approx(TRUTH, abs=1e-5)


@pytest.mark.parametrize("oracle", ["drake", "kernel"])
@pytest.mark.parametrize(("margin", "is_free"), [(0.0, True), (0.0249, True), (0.0252, False)])
def test_verdicts_go_by_the_true_distance(
    tmp_path: Path, oracle: str, margin: float, is_free: bool
) -> None:
    world = block_world(tmp_path, margin)
    group, margins = world.group("r"), world.margins()
    if oracle == "drake":
        judge = DrakeCollisionOracle(world.drake, group, world.state, margins)
    else:
        scene = kernel_scene(world.drake)
        if scene is None:
            pytest.skip("the native kernel is not built")
        judge = KernelCollisionOracle(world.drake, scene, group, world.state, margins)
    assert judge.is_free(POSE) is is_free
    assert judge.are_free(POSE[None]).tolist() == [is_free]
