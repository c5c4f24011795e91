"""Distances of round shapes that people are told are never larger than the true ones."""

from itertools import combinations_with_replacement
from pathlib import Path

import numpy as np
import pytest

import planning
from planning.kernel.shape_distance import distance_bounds
from planning.world.kernel.convex_shapes import convex_shape
from planning.world.world import World
from tests.conftest import whole_world
from tests.profiles import num_cases, rng_of

SHAPES = {
    "cylinder": {"cylinder": {"radius": 0.4, "length": 0.5}},
    "capsule": {"capsule": {"radius": 0.2, "length": 0.9}},
    "ellipsoid": {"ellipsoid": [0.5, 0.1, 0.3]},
    "sphere": {"sphere": 0.3},
    "box": {"box": [0.7, 0.3, 0.2]},
}
MOVER = """<robot name="m"><link name="base"/><link name="a"/>
<joint name="j" type="floating"><parent link="base"/><child link="a"/></joint></robot>"""


def world_of(folder: Path, held: str, still: str) -> World:
    file = folder / "mover.urdf"
    file.write_text(MOVER)
    things = [
        {"name": "held", "shape": SHAPES[held], "movable": True, "attached": {"frame": "r::a"}},
        {"name": "still", "shape": SHAPES[still]},
    ]
    scene = {"robots": [{"name": "r", "model": str(file)}], "objects": things}
    return planning.load_world(planning.parse_scene(scene))


def true_distance(world: World, q: np.ndarray) -> tuple[float, float]:
    """Return two bounds on the distance of the two things, next to each other."""
    model = whole_world(world).drake
    inspector = model.scene_graph.model_inspector()
    context = model.diagram.CreateDefaultContext()
    plant_context = model.plant.GetMyMutableContextFromRoot(context)
    model.plant.SetPositions(plant_context, world.embed(world.group("r"), q))
    query_context = model.scene_graph.GetMyContextFromRoot(context)
    query = model.scene_graph.get_query_output_port().Eval(query_context)
    ids = [
        i
        for name in ("held", "still")
        for i in model.plant.GetCollisionGeometriesForBody(model.plant.get_body(model.bodies[name]))
    ]
    shapes = [convex_shape(inspector.GetShape(i)) for i in ids]
    poses = [np.array(query.GetPoseInWorld(i).GetAsMatrix4()) for i in ids]
    found = distance_bounds((shapes[0], shapes[1]), (poses[0], poses[1]), np.zeros(3))
    return found.lower, found.upper


@pytest.mark.campaign
@pytest.mark.parametrize(("held", "still"), list(combinations_with_replacement(SHAPES, 2)), ids=str)
def test_no_distance_is_larger_than_the_true_one(tmp_path: Path, held: str, still: str) -> None:
    world, rng = world_of(tmp_path, held, still), rng_of(3)
    for _ in range(num_cases(12)):
        turn = rng.normal(size=4)
        q = np.concatenate([turn / np.linalg.norm(turn), rng.normal(0, 0.8, 3)])
        low, high = true_distance(world, q)
        (verdict,) = planning.check_configurations(world, "r", q[None])
        reported = verdict.nearest.distance
        if high <= 1e-6:
            assert reported <= 1e-6
            continue
        assert high - low < 1e-8
        assert (1 - 2e-6) * low - 2e-8 <= reported <= high + 1e-12
        # It counts for margins as well.
        for margin, keeps in ((0.9999 * low, True), (high + 1e-9, False)):
            (held_to,) = planning.check_configurations(world, "r", q[None], margin)
            assert held_to.valid == keeps


@pytest.mark.campaign
def test_the_nearest_is_that_of_all_true_distances(tmp_path: Path) -> None:
    file = tmp_path / "mover.urdf"
    file.write_text(MOVER)
    rng = rng_of(4)
    held = {"name": "held", "shape": SHAPES["cylinder"], "attached": {"frame": "r::a"}}
    things = [{**held, "movable": True}]
    for i, shape in enumerate(list(SHAPES.values()) * 2):
        place = {"position": rng.normal(0, 3, 3).tolist()}
        things.append({"name": f"o{i}", "shape": shape, "pose": place})
    scene = {"robots": [{"name": "r", "model": str(file)}], "objects": things}
    world = planning.load_world(planning.parse_scene(scene))
    probe, group = world.distance_probe(world.margins()), world.group("r")
    for _ in range(num_cases(12)):
        turn = rng.normal(size=4)
        q = np.concatenate([turn / np.linalg.norm(turn), rng.normal(0, 2, 3)])
        full = world.embed(group, q)
        every = probe.pairs_within(full, 100.0, exactly=True)
        least = float(rng.uniform(0, 3))
        found = probe.nearest_within(full, 100.0, least)
        assert found[0].distance == pytest.approx(every[0].distance, abs=1e-9)
        near = {pair.bodies for pair in every if pair.distance < least - 1e-9}
        assert near <= {pair.bodies for pair in found}
