"""GJK bounds hold at every step and meet, also where Drake overstates a distance."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.geometry import Box
from pydrake.math import RigidTransform

from planning.certify.certifier import certify
from planning.certify.clearance.collision_shapes import collision_shapes
from planning.kernel.gjk import GjkResult, separation
from planning.world.collision.margins import PairMargins
from tests.certify.chains import FLOATING, PLANAR, Builder, Robot, random_pose, random_shape
from tests.certify.conftest import quintic
from tests.clocks import no_hurry
from tests.profiles import num_cases

pytestmark = pytest.mark.usefixtures("implementation")


def hull(points: np.ndarray) -> Any:
    return lambda n: points[np.argmax(points @ n)]


def test_a_corner_an_edge_and_a_face() -> None:
    corners = np.array([[1.0, 1, 1], [1, 1, -1], [1, -1, 1], [1, -1, -1], [3, 1, 1], [3, -1, -1]])
    face = separation(hull(corners), np.array([0.3, 0.5, 0.1]), np.inf)
    assert face.lower == pytest.approx(1.0)
    assert face.upper == pytest.approx(1.0)
    assert face.direction == pytest.approx([1.0, 0.0, 0.0], abs=1e-6)
    edge = separation(hull(corners + np.array([0.0, 2.0, 0.0])), np.array([0.3, 0.5, 0.1]), np.inf)
    assert edge.lower == pytest.approx(np.sqrt(2))
    corner = separation(
        hull(corners + np.array([0.0, 2.0, 2.0])), np.array([0.3, 0.5, 0.1]), np.inf
    )
    assert corner.lower == pytest.approx(np.sqrt(3))


def test_overlap_has_no_upper_bound_above_zero() -> None:
    points = np.random.default_rng(0).normal(size=(30, 3))
    found = separation(hull(points), np.ones(3), np.inf)
    assert found.upper == 0
    assert found.lower < 0


def test_a_bound_that_is_enough_ends_the_search() -> None:
    steps: list[np.ndarray] = []
    points = np.random.default_rng(0).normal(size=(300, 3)) + np.array([9.0, 0.0, 0.0])

    def support(n: np.ndarray) -> np.ndarray:
        steps.append(n)
        return points[np.argmax(points @ n)]

    assert separation(support, np.array([1.0, 0.0, 0.0]), 1.0).lower >= 1.0
    assert len(steps) == 1


def of_two(seed: int) -> tuple[GjkResult, float, float]:
    """Return our bounds on two random shapes' distance, Drake's word for it, and the tolerance."""
    rng = np.random.default_rng(seed)
    builder = Builder()
    for _ in range(2):
        builder.link(FLOATING, random_shape(rng, 0.1))
    robot = builder.build()
    shapes = collision_shapes(robot.model)
    (R_A, p_a), (R_B, p_b) = (
        (x.rotation().matrix(), x.translation())
        for x in (random_pose(rng, 0.1), random_pose(rng, 0.1))
    )
    plant = robot.model.plant
    context = robot.model.diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    for body, R, p in zip(shapes.bodies, (R_A, R_B), (p_a, p_b), strict=True):
        matrix = np.column_stack([R, p])
        plant.SetFreeBodyPose(plant_context, builder.links[int(body) - 1], RigidTransform(matrix))
    scene_graph = robot.model.scene_graph
    query: Any = scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(context))
    (found,) = query.ComputeSignedDistancePairwiseClosestPoints(10.0)

    def support(n: np.ndarray) -> np.ndarray:
        return shapes.support_point(0, R_A, p_a, n) - shapes.support_point(1, R_B, p_b, -n)

    return separation(support, p_a - p_b, np.inf), float(found.distance), 1e-4


@given(seed=st.integers(0, 100_000))
@settings(max_examples=num_cases(6))
def test_the_bounds_meet_about_drakes_distance(seed: int) -> None:
    found, drake, tolerance = of_two(seed)
    assert found.lower <= found.upper + 1e-9
    if drake > 1e-3:
        assert found.lower <= drake + 1e-9
        assert found.upper - found.lower <= tolerance
        assert found.upper <= drake + tolerance
    elif drake < -1e-3:
        assert found.lower < 0


def parallel_boxes() -> tuple[Robot, np.ndarray, float]:
    """Return two boxes whose distance Drake 1.58 overstates, where that is, and the true one."""
    builder = Builder()
    at = RigidTransform(np.array([0.0, 0.0, 0.03]))
    builder.link(PLANAR, Box(0.2, 0.05, 0.05), None, at)
    builder.obstacle("post", Box(0.02, 0.1, 0.06), RigidTransform(np.array([0.02, -0.45, 0.03])))
    pose = np.array([0.15230923, -0.36251579, 0.02424064])
    cosine, sine = np.cos(pose[2]), np.sin(pose[2])
    corner = pose[:2] + np.array([[cosine, -sine], [sine, cosine]]) @ [-0.1, -0.025]
    return builder.build(), pose, float(np.linalg.norm(corner - [0.03, -0.40]))


def test_an_overstated_drake_distance_is_not_a_lower_bound() -> None:
    robot, pose, true = parallel_boxes()
    still = quintic(robot.group, pose, pose + 1e-9, 1.0)
    request = robot.request(still, PairMargins(true + 1e-3))
    certificate, _ = certify(robot.model, request, no_hurry(9.0))
    assert not certificate.proven
    request = robot.request(still, PairMargins(true - 1e-3))
    certificate, _ = certify(robot.model, request, no_hurry(9.0))
    assert certificate.proven
    resolution = certificate.checks[-1].resolution
    assert certificate.min_clearance - resolution <= true + 1e-6
    assert certificate.min_clearance == pytest.approx(true, abs=1.1e-3)
