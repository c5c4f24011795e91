"""Every pair of bodies is looked at, or listed with the reason why it is not."""

import re
from itertools import combinations, product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydrake.multibody.tree import BodyIndex

import planning
from planning import scene_summary
from planning.kernel.shape_distance import distance_bounds
from planning.world.kernel.convex_shapes import convex_shape
from planning.world.loading.adjacent_links import _AdjacentPairProbe
from planning.world.world import World
from tests.clocks import no_hurry
from tests.conftest import bundled_world
from tests.profiles import pairs

SCENES = [
    "ur5e_pickup",
    "panda_shelf",
    "maze_2d",
    "window_3d",
    "irb120_cell",
    "two_arms",
    "parallel_parking",
]
# An arm of 1 m on an axis 1 m beside a pedestal of its own robot.
BESIDE = """<robot name="m"><link name="base"><collision><origin xyz="0 0 0.5"/>
<geometry><box size="0.2 0.2 1"/></geometry></collision></link>
<link name="a"><collision><origin xyz="{reach} 0 0"/>
<geometry><box size="1 0.05 0.05"/></geometry></collision></link>
<joint name="j" type="{kind}"><parent link="base"/><child link="a"/><origin xyz="{beside} 0 0.5"/>
<axis xyz="0 0 1"/>{limit}</joint></robot>"""
LIMIT = '<limit lower="-3.2" upper="3.2" velocity="1" effort="1"/>'


def robot(folder: Path, beside: float = 1.0, reach: float = 0.5, kind: str = "revolute") -> World:
    file = folder / "arm.urdf"
    limit = LIMIT if kind == "revolute" else '<limit velocity="1" effort="1"/>'
    file.write_text(BESIDE.format(beside=beside, reach=reach, kind=kind, limit=limit))
    scene = {"robots": [{"name": "r", "model": str(file)}]}
    return planning.load_world(planning.parse_scene(scene))


def pairs_of(world: World, *, checked: bool) -> set[frozenset[str]]:
    """Return the pairs of bodies with shapes that are checked, or all that could be."""
    plant, names = world.drake.plant, world.drake.body_names
    inspector = world.drake.scene_graph.model_inspector()
    if checked:
        return {
            frozenset(
                names[plant.GetBodyFromFrameId(inspector.GetFrameId(i)).index()] for i in pair
            )
            for pair in inspector.GetCollisionCandidates()
        }
    shaped = [
        name
        for index, name in names.items()
        if plant.GetCollisionGeometriesForBody(plant.get_body(BodyIndex(index)))
    ]
    return {frozenset(pair) for pair in combinations(shaped, 2)}


@pytest.mark.parametrize("name", SCENES)
def test_what_is_checked_and_what_is_listed_are_all_pairs(name: str) -> None:
    world = bundled_world(name)
    listed = {frozenset(pair.bodies) for pair in scene_summary(world).unchecked}
    checked, every = pairs_of(world, checked=True), pairs_of(world, checked=False)
    assert listed.isdisjoint(checked)
    left = every - checked - listed
    # Objects that stand in the world, which no robot's body is among.
    assert all("::" not in body for pair in left for body in pair)
    assert all(pair.evidence for pair in scene_summary(world).unchecked)


@pytest.mark.parametrize("name", SCENES)
def test_contexts_look_at_the_same_pairs_as_the_model(name: str) -> None:
    model = bundled_world(name).drake
    context = model.diagram.CreateDefaultContext()
    query_context = model.scene_graph.GetMyContextFromRoot(context)
    query = model.scene_graph.get_query_output_port().Eval(query_context)
    inspector = model.scene_graph.model_inspector()
    assert query.inspector().GetCollisionCandidates() == inspector.GetCollisionCandidates()


@pytest.mark.parametrize("kind", ["revolute", "continuous"])
def test_an_arm_that_swings_into_its_own_pedestal_is_refused(tmp_path: Path, kind: str) -> None:
    """The two are joined by a joint; the arm was "proven" 100 mm inside the pedestal."""
    world = robot(tmp_path, kind=kind)
    assert scene_summary(world).unchecked == ()
    times, rates = np.array([0.0, 10.0]), np.zeros((2, 1))
    joints = world.group("r").joints
    for goal, is_free in ((2.5, True), (3.14, False)):
        motion = planning.trajectory_through(joints, times, np.array([[0.0], [goal]]), rates)
        certificate, _ = planning.certify_trajectory(world, "r", motion, deadline=no_hurry())
        assert certificate.proven == is_free
    assert certificate.min_clearance < 0
    (verdict,) = planning.check_configurations(world, "r", np.array([[3.14]]))
    assert not verdict.valid
    assert verdict.violations[0].bodies == ("r::a", "r::base")


@pytest.mark.parametrize(
    ("beside", "reach"),
    [
        (0.0, 0.5),  # the arm's root is in the pedestal, wherever it turns
        (0.1, 0.5),  # its face is flush with the pedestal's at the default position
    ],
)
def test_neighbours_whose_shapes_meet_about_their_joint_are_listed(
    tmp_path: Path, beside: float, reach: float
) -> None:
    world = robot(tmp_path, beside, reach)
    (pair,) = scene_summary(world).unchecked
    assert (pair.bodies, pair.reason) == (("r::a", "r::base"), "adjacent")
    assert "joint j" in pair.evidence
    assert pairs_of(world, checked=True) == set()


def test_a_certificate_lists_what_it_does_not_look_at() -> None:
    world = bundled_world("irb120_cell")
    group = world.group("arm")
    home = world.positions(group)
    motion = planning.trajectory_through(
        group.joints, np.array([0.0, 1.0]), np.stack([home, home]), np.zeros((2, 6))
    )
    certificate, _ = planning.certify_trajectory(world, "arm", motion, deadline=no_hurry())
    assert certificate.unchecked == scene_summary(world).unchecked
    reasons = {pair.bodies: pair.reason for pair in certificate.unchecked}
    assert reasons["arm::base_link", "arm::link_1"] == "adjacent"
    assert reasons["arm::base_link", "arm::link_2"] == "allowed"
    assert set(reasons.values()) >= {"adjacent", "allowed", "welded", "welded_to_world"}


def test_what_is_held_may_touch_its_holder_and_says_so() -> None:
    scene = planning.parse_scene({
        "robots": [{"name": "arm", "model": "ur5e"}],
        "objects": [
            {
                "name": "can",
                "shape": {"sphere": 0.03},
                "movable": True,
                "attached": {"frame": "arm::tcp"},
            }
        ],
    })
    world = planning.load_world(scene)
    held = [pair for pair in scene_summary(world).unchecked if pair.reason == "held"]
    assert held
    assert all("can" in pair.bodies for pair in held)


NEAR = """<robot name="m">
<link name="base"><collision><geometry>{base}</geometry></collision></link>
<link name="a"><collision><origin xyz="{gap} 0 {up}" rpy="0.3 1.2 0.4"/><geometry>{arm}</geometry>
</collision></link><joint name="j" type="continuous"><parent link="base"/><child link="a"/>
<axis xyz="0 0 1"/><limit velocity="1" effort="1"/></joint></robot>"""
SHAPES = [
    '<box size="0.2 0.1 0.1"/>',
    '<cylinder radius="0.1" length="0.1"/>',
    '<capsule radius="0.05" length="0.1"/>',
    '<sphere radius="0.1"/>',
]


def least_shown(folder: Path, text: str) -> tuple[float, World]:
    """Return how far apart the two links are said to be at least, and the world."""
    file = folder / "near.urdf"
    file.write_text(text)
    scene = {"robots": [{"name": "r", "model": str(file)}]}
    world = planning.load_world(planning.parse_scene(scene))
    (pair,) = scene_summary(world).unchecked
    match = re.match(r"at least ([^ ]+) m apart wherever joint j turns to", pair.evidence)
    assert match, pair.evidence
    return float(match[1]), world


@pytest.mark.campaign
@pytest.mark.parametrize(("shapes", "factor"), pairs(list(product(SHAPES, SHAPES)), [1.0, 3.0]))
def test_links_shown_never_to_touch_are_so_far_apart_whatever_drake_measures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, shapes: tuple[str, str], factor: float
) -> None:
    """Drake's distances of separate shapes are too large now and then: here they all are."""
    measured = _AdjacentPairProbe._measure

    def enlarged(*args: Any) -> tuple[float, np.ndarray]:
        distance, normal = measured(*args)
        return factor * distance if distance > 0 else distance, normal

    monkeypatch.setattr(_AdjacentPairProbe, "_measure", enlarged)
    base, arm = shapes
    lower_bound, world = least_shown(tmp_path, NEAR.format(base=base, arm=arm, gap=0.3, up=0.02))
    model = world.drake
    inspector = model.scene_graph.model_inspector()
    ids = [
        i
        for name in ("r::base", "r::a")
        for i in model.plant.GetCollisionGeometriesForBody(model.plant.get_body(model.bodies[name]))
    ]
    known = convex_shape(inspector.GetShape(ids[0])), convex_shape(inspector.GetShape(ids[1]))
    context = model.diagram.CreateDefaultContext()
    plant_context = model.plant.GetMyMutableContextFromRoot(context)
    query_context = model.scene_graph.GetMyContextFromRoot(context)
    least = np.inf
    for angle in np.linspace(-np.pi, np.pi, 61):
        model.plant.SetPositions(plant_context, np.array([angle]))
        query = model.scene_graph.get_query_output_port().Eval(query_context)
        poses = [np.array(query.GetPoseInWorld(i).GetAsMatrix4()) for i in ids]
        found = distance_bounds(known, (poses[0], poses[1]), np.zeros(3))
        assert found.upper - found.lower < 1e-8
        least = min(least, found.upper)
    assert 0 < lower_bound <= least
