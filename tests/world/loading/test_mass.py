"""What objects weigh: known inertias, scenes that say so, and the energy of what is held."""

import numpy as np
import pytest
from pydrake.multibody.tree import SpatialInertia

import planning
from planning import scene_document
from planning.domain.curves.interpolation import trajectory_through
from planning.domain.geometry.pose import Pose
from planning.domain.geometry.shapes import Box, Convex, Cylinder, Shape, Sphere
from planning.domain.robot.payload import Payload
from planning.domain.scene.scene import SceneObject
from planning.errors import SceneInvalid
from planning.world.loading.mass import spatial_inertia
from planning.world.mechanics.dynamics import GroupDynamics

CUBE = np.array([[x, y, z] for x in (0, 0.2) for y in (0, 0.2) for z in (0, 0.2)], dtype=float)
KNOWN: dict[str, tuple[Shape, list[float]]] = {
    "box": (Box(np.array([0.1, 0.2, 0.3])), [0.13, 0.10, 0.05]),
    "sphere": (Sphere(0.1), [0.048] * 3),
    "cylinder": (Cylinder(0.1, 0.2), [0.07, 0.07, 0.06]),
}


@pytest.mark.parametrize("name", KNOWN)
def test_inertias_are_those_of_solids_of_twelve_kilograms(name: str) -> None:
    shape, moments = KNOWN[name]
    inertia = spatial_inertia(SceneObject("a", shape, Pose.identity(), mass=12.0))
    assert inertia.get_mass() == 12.0
    found = np.diag(inertia.CalcRotationalInertia().CopyToFullMatrix3())
    np.testing.assert_allclose(found, moments, rtol=1e-9)


def test_a_hull_weighs_at_its_centroid_and_a_centre_of_ones_own_moves_it() -> None:
    hull = SceneObject("a", Convex(CUBE), Pose.identity(), mass=6.0)
    inertia = spatial_inertia(hull)
    np.testing.assert_allclose(inertia.get_com(), [0.1, 0.1, 0.1], atol=1e-12)
    center = np.array([0.1, 0.2, 0.3])
    moved = spatial_inertia(
        SceneObject("a", Box(np.full(3, 0.2)), Pose.identity(), mass=6.0, center_of_mass=center)
    )
    expected = SpatialInertia.SolidBoxWithMass(6.0, 0.2, 0.2, 0.2).Shift(-center)
    np.testing.assert_allclose(moved.CopyToFullMatrix6(), expected.CopyToFullMatrix6(), atol=1e-12)


THING = {
    "name": "thing",
    "shape": {"box": [0.1, 0.1, 0.3]},
    "pose": {"position": [0.02, 0.0, 0.3], "rpy": [0.2, 0.1, 0.3]},
    "attached": {"frame": "arm::tool0"},
    "movable": True,
}
BAD = {
    "a mass of nothing": {"mass": 0},
    "a negative mass": {"mass": -1.0},
    "a mass in words": {"mass": "2"},
    "a centre without a mass": {"center_of_mass": [0, 0, 0]},
    "a half space": {"mass": 1.0, "shape": {"half_space": {}}},
}


def scene_with(**changes: object) -> dict[str, object]:
    robot = {"name": "arm", "model": "ur5e", "positions": "home"}
    return {"robots": [robot], "objects": [{**THING, **changes}]}


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_weigh_so_is_refused(name: str) -> None:
    with pytest.raises(SceneInvalid, match="objects"):
        planning.parse_scene(scene_with(**BAD[name]))


def test_masses_are_written_as_they_were_read_and_stay_when_it_is_put_down() -> None:
    scene = planning.parse_scene(scene_with(mass=2.5, center_of_mass=[0.0, 0.01, 0.02]))
    assert planning.parse_scene(scene_document(scene).model_dump()) == scene
    down = planning.edit_scene(scene, [planning.DetachObject("thing")])
    assert down.objects[0].mass == 2.5


def test_power_is_the_change_of_energy_of_all_that_moves() -> None:
    world = planning.load_world(planning.parse_scene(scene_with(mass=3.0)))
    group = world.group("arm")
    rng = np.random.default_rng(4)
    rows = world.positions(group) + rng.normal(0.0, 0.5, (4, 6))
    motion = trajectory_through(group.joints, np.array([0.0, 0.5, 1.1, 1.6]), rows)
    plant = world.drake.plant
    context = plant.CreateDefaultContext()
    own = world.drake.velocity_indices(group)

    def energy(t: np.ndarray) -> np.ndarray:
        found = np.empty(len(t))
        for i, (q, v) in enumerate(
            zip(world.embed(group, motion.positions(t)), motion.velocities(t), strict=True)
        ):
            full = np.zeros(plant.num_velocities())
            full[own] = v
            plant.SetPositions(context, q)
            plant.SetVelocities(context, full)
            found[i] = plant.CalcKineticEnergy(context) + plant.CalcPotentialEnergy(context)
        return found

    times, step = np.linspace(0.05, 1.55, 61), 1e-5
    efforts = GroupDynamics(world, group).efforts(
        motion.positions(times), motion.velocities(times), motion.accelerations(times)
    )
    power = (efforts * motion.velocities(times)).sum(axis=1)
    change = (energy(times + step) - energy(times - step)) / (2 * step)
    np.testing.assert_allclose(power, change, atol=1e-4 * np.abs(power).max())


def test_a_payload_is_the_same_burden_as_the_thing_held() -> None:
    held = planning.load_world(planning.parse_scene(scene_with(mass=3.0)))
    bare = planning.load_world(planning.parse_scene(scene_with()))
    group = held.group("arm")
    moments = 3.0 / 12 * np.array([0.1, 0.1, 0.02])
    payload = Payload.from_parts("thing", 3.0, (0, 0, 0), (*moments, 0, 0, 0))
    rng = np.random.default_rng(1)
    motion = rng.normal(size=(3, 20, 6))
    wanted = GroupDynamics(held, group).efforts(*motion)
    found = GroupDynamics(bare, group, payload).efforts(*motion)
    np.testing.assert_allclose(found, wanted, atol=1e-9)
    assert np.abs(found - GroupDynamics(bare, group).efforts(*motion)).max() > 1
