"""Distances where Drake has none: as true as Drake's are elsewhere."""

from itertools import combinations_with_replacement
from typing import Any

import numpy as np
import pytest
from pydrake.geometry import Box, Capsule, Cylinder, Ellipsoid, Sphere
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.framework import DiagramBuilder

from planning.world.collision.drake_distance import distances_within, pair_distance
from tests.profiles import num_cases, rng_of


def placed(rotation: list[list[float]], position: list[float]) -> RigidTransform:
    return RigidTransform(RotationMatrix(np.array(rotation)), position)


# Found by the adversary: an ellipsoid and a capsule that touch, at which FCL throws.
TOUCHING = (
    (
        Ellipsoid(3.793286827291493, 2.792376054086344, 8.8572679381773),
        placed(
            [
                [-0.9391835296027798, 0.11558125947948503, -0.32338099846290436],
                [-0.14105294554469175, 0.728732003814222, 0.6701147164255348],
                [0.31311078592551744, 0.6749745469823619, -0.6681100183824967],
            ],
            [-80.21985014863199, 7.0374057485750665, 256.3128817753271],
        ),
    ),
    (
        Capsule(19.209000137858133, 49.94020134581285),
        placed(
            [
                [-0.858319974540751, 0.18955322536541647, 0.4768190391101555],
                [0.18771714525256533, -0.7488464656703662, 0.6356030555552956],
                [0.47754486143460034, 0.6350579072860747, 0.6071674890101081],
            ],
            [-82.44416090052147, 10.485293588855042, 224.40976800817566],
        ),
    ),
)
SHAPES = [
    Sphere(0.3),
    Box(0.4, 0.2, 0.6),
    Cylinder(0.2, 0.5),
    Capsule(0.1, 0.4),
    Ellipsoid(0.1, 0.2, 0.4),
]


class Query:
    """Drake's query object of two shapes, and one that fails where FCL might."""

    def __init__(self, *placed: tuple[Any, RigidTransform]) -> None:
        builder = DiagramBuilder()
        plant, graph = AddMultibodyPlantSceneGraph(builder, 0.0)
        self.ids = []
        for i, (shape, X_WG) in enumerate(placed):
            body = plant.AddRigidBody(f"b{i}", SpatialInertia.SolidSphereWithMass(1.0, 1.0))
            friction = CoulombFriction(1.0, 1.0)
            self.ids.append(plant.RegisterCollisionGeometry(body, X_WG, shape, f"g{i}", friction))
        plant.Finalize()
        self._diagram = builder.Build()
        self._context = self._diagram.CreateDefaultContext()
        graph_context = graph.GetMyContextFromRoot(self._context)
        self.drake: Any = graph.get_query_output_port().Eval(graph_context)
        self.inspector = self.drake.inspector
        self.GetPoseInWorld = self.drake.GetPoseInWorld

    def ComputeSignedDistancePairClosestPoints(self, *_: Any) -> Any:  # noqa: N802
        raise RuntimeError

    def ComputeSignedDistancePairwiseClosestPoints(self, _: float) -> Any:  # noqa: N802
        raise RuntimeError


def test_of_shapes_at_which_drake_throws_there_is_a_distance() -> None:
    query = Query(*TOUCHING)
    with pytest.raises(RuntimeError, match="outside of the polytope"):
        query.drake.ComputeSignedDistancePairClosestPoints(*query.ids)
    found = pair_distance(query.drake, *query.ids)
    assert abs(found.distance) < 1e-5
    (same,) = distances_within(query.drake, 0.1)
    assert same.distance == found.distance
    assert {same.id_A, same.id_B} == set(query.ids)
    assert distances_within(query.drake, -1.0) == []


@pytest.mark.parametrize(("a", "b"), list(combinations_with_replacement(SHAPES, 2)))
def test_what_is_searched_is_what_drake_finds(a: Any, b: Any) -> None:
    rng = rng_of(7)
    for _ in range(num_cases(3, 60)):
        p_b = rng.normal(size=3) * 0.7
        turns = [turn(rng) for _ in range(2)]
        query = Query((a, RigidTransform(turns[0], [0, 0, 0])), (b, RigidTransform(turns[1], p_b)))
        theirs = query.drake.ComputeSignedDistancePairClosestPoints(*query.ids)
        ours = pair_distance(query, *query.ids)
        if theirs.distance <= 0:
            assert ours.distance <= 0
            continue
        assert ours.distance <= theirs.distance + 1e-6
        assert ours.distance >= theirs.distance * (1 - 1e-3) - 1e-3
        p_wa, p_wb = (
            query.GetPoseInWorld(i) @ p
            for i, p in zip(query.ids, (ours.p_ACa, ours.p_BCb), strict=True)
        )
        assert np.linalg.norm(p_wa - p_wb) == pytest.approx(ours.distance, abs=1e-4)
        assert ours.nhat_BA_W @ (p_wa - p_wb) > 0


def turn(rng: np.random.Generator) -> RotationMatrix:
    return RotationMatrix(RollPitchYaw(rng.uniform(-3, 3, size=3)))
