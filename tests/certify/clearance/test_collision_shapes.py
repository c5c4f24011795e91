"""Slabs bound distances from below, and reach them."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Mesh,
    MeshcatCone,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform

from planning.certify.clearance.collision_shapes import _summands, collision_shapes
from planning.errors import ModelInvalid
from tests.certify.chains import FLOATING, Builder, random_pose, random_shape

SHAPES = {
    "box": Box(0.2, 0.3, 0.4),
    "sphere": Sphere(0.1),
    "cylinder": Cylinder(0.1, 0.3),
    "capsule": Capsule(0.1, 0.3),
    "ellipsoid": Ellipsoid(0.1, 0.2, 0.3),
    "convex": Convex(np.asfortranarray(np.eye(3) * [0.1, 0.2, 0.3] - 0.05), "corner"),
}


def surface(shape: Shape, count: int = 4000) -> np.ndarray:
    """Return points of a shape, dense on what sticks out."""
    rng = np.random.default_rng(0)
    unit = rng.normal(size=(count, 3))
    unit /= np.linalg.norm(unit, axis=1)[:, None]
    match shape:
        case Box():
            return np.sign(unit) * shape.size() / 2
        case Sphere():
            return unit * shape.radius()
        case Ellipsoid():
            return unit * [shape.a(), shape.b(), shape.c()]
        case Capsule():
            ends = np.sign(unit[:, 2:]) * [0.0, 0.0, shape.length() / 2]
            return unit * shape.radius() + ends
        case Cylinder():
            angle = rng.uniform(0, 2 * np.pi, count)
            disk = np.stack([np.cos(angle), np.sin(angle)], axis=1) * shape.radius()
            return np.column_stack([disk, np.sign(unit[:, 2]) * shape.length() / 2])
        case _:
            hull: Any = shape.GetConvexHull()
            return np.array([hull.vertex(i) for i in range(hull.num_vertices())])


@pytest.mark.parametrize("name", SHAPES)
def test_reach_is_that_of_the_farthest_point(name: str) -> None:
    builder = Builder()
    builder.link(FLOATING, SHAPES[name])
    shapes = collision_shapes(builder.build().model)
    points = surface(SHAPES[name])
    rng = np.random.default_rng(1)
    for _ in range(30):
        n = rng.normal(size=3)
        n /= np.linalg.norm(n)
        pose = random_pose(rng, 1.0)
        rotation, position = pose.rotation().matrix(), pose.translation()
        reach = shapes.support(np.array([0]), rotation[None], position[None], n[None])[0]
        farthest = float(((points @ rotation.T + position) @ n).max())
        assert farthest - 1e-12 <= reach <= farthest + 2e-3
    distances = np.linalg.norm(points - shapes.centers[0], axis=1)
    assert distances.max() <= shapes.radii[0] + 1e-12
    assert distances.max() >= 0.99 * shapes.radii[0]


@given(seed=st.integers(0, 10_000))
def test_the_slab_along_drakes_direction_is_its_distance(seed: int) -> None:
    rng = np.random.default_rng(seed)
    builder = Builder()
    for _ in range(2):
        builder.link(FLOATING, random_shape(rng, 0.1), None, x_bg=random_pose(rng, 0.05))
    robot = builder.build()
    shapes = collision_shapes(robot.model)
    plant, scene_graph = robot.model.plant, robot.model.scene_graph
    context = robot.model.diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    poses = [random_pose(rng, 0.3), random_pose(rng, 0.3)]
    for link, pose in zip(builder.links, poses, strict=True):
        plant.SetFreeBodyPose(plant_context, link, pose)
    query: Any = scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(context))
    (found,) = query.ComputeSignedDistancePairwiseClosestPoints(10.0)
    if found.distance < 1e-3:
        return
    rows = np.array([shapes.rows[found.id_A], shapes.rows[found.id_B]])
    at = [query.GetPoseInWorld(found.id_A), query.GetPoseInWorld(found.id_B)]
    rotations = np.array([x.rotation().matrix() for x in at])
    positions = np.array([x.translation() for x in at])
    n = found.nhat_BA_W
    ahead, behind = shapes.support(rows, rotations, positions, np.array([-n, n]))
    slab = -ahead - behind
    assert slab <= found.distance + 1e-9
    # Drake's iterations end early now and then; a bound that is low proves less, never too much.
    assert slab >= found.distance - 0.01


def test_a_scaled_mesh_reaches_as_far_as_its_scaled_hull(tmp_path: Path) -> None:
    obj = tmp_path / "wedge.obj"
    obj.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    builder = Builder()
    builder.link(FLOATING, Mesh(str(obj), scale3=np.array([0.1, 0.2, 0.3])))
    shapes = collision_shapes(builder.build().model)
    identity, origin = np.eye(3)[None], np.zeros((1, 3))
    for axis, length in enumerate((0.1, 0.2, 0.3)):
        n = np.eye(3)[axis][None]
        assert shapes.support(np.array([0]), identity, origin, n)[0] == pytest.approx(length)


def test_half_spaces_have_no_end() -> None:
    builder = Builder()
    builder.obstacle("ground", HalfSpace(), RigidTransform())
    shapes = collision_shapes(builder.build().model)
    assert shapes.is_half_space[0]
    assert np.isinf(shapes.radii[0])


def test_shapes_that_are_unknown_are_refused() -> None:
    with pytest.raises(ModelInvalid, match="MeshcatCone"):
        _summands(MeshcatCone(0.1, 0.1, 0.1))
