"""Grippers of the library: how far they close on an object, and what is proven of that."""

import time

import numpy as np
import pytest

import planning
from planning.errors import GraspMissed, NotCertified, ProblemInvalid
from planning.world.mechanics.grippers import gripper_of
from tests.profiles import rng_of, seeds

GROUPS = {"ur5e": "arm::gripper", "panda": "arm::hand"}
WIDEST = {"ur5e": 0.05, "panda": 0.08}
GAP = 2e-4


def deadline():
    return planning.Deadline.after(60.0, time.monotonic)


def document(model, *things):
    return {
        "name": "grasp",
        "robots": [{"name": "arm", "model": model, "positions": "ready"}],
        "objects": list(things),
    }


def bare(model):
    return planning.load_world(planning.parse_scene(document(model)))


@pytest.mark.parametrize("model", GROUPS)
def test_a_group_that_is_no_gripper_is_refused_by_its_joints(model):
    world = bare(model)
    command = planning.GripperCommand(width=0.01)
    with pytest.raises(ProblemInvalid) as fault:
        planning.gripper_motion(world, "arm", command, deadline=deadline())
    names = [joint.name for joint in world.group("arm").joints]
    assert fault.value.evidence["joints"] == names
    assert all(f"{name} (revolute)" in fault.value.detail for name in names)
    assert fault.value.evidence["known"] == [GROUPS[model]]


def with_ball(model, radius, offset):
    """A world with a ball beside the origin of the tool frame [m], and that frame."""
    empty = bare(model)
    tool = empty.group(GROUPS[model]).tool_frames[0]
    place = empty.frame_pose(tool, empty.state) @ planning.Pose.from_parts(offset)
    ball = {
        "name": "ball",
        "shape": {"sphere": radius},
        "movable": True,
        "pose": {"position": place.position.tolist()},
    }
    return planning.load_world(planning.parse_scene(document(model, ball))), tool


def grasped(world, model, tool, **options):
    command = planning.GripperCommand(grasp=planning.AttachObject("ball", tool), gap=GAP, **options)
    return planning.gripper_motion(world, GROUPS[model], command, deadline=deadline())


@pytest.mark.parametrize("model", GROUPS)
def test_bundled_grippers_are_known_by_their_widths(model):
    world = bare(model)
    found = {group.name: gripper_of(world, group) for group in world.groups}
    grippers = {name: one for name, one in found.items() if one is not None}
    assert set(grippers) == {GROUPS[model]}
    gripper = grippers[GROUPS[model]]
    assert gripper.max_width == pytest.approx(WIDEST[model])
    for width in np.linspace(0.0, gripper.max_width, 7):
        assert gripper.width(gripper.position(width)) == pytest.approx(width, abs=1e-12)
    for width in (-1e-3, gripper.max_width + 1e-3):
        with pytest.raises(ProblemInvalid):
            gripper.position(width)
    summary = planning.scene_summary(world).groups[GROUPS[model]]
    assert summary.gripper == gripper


@pytest.mark.parametrize("seed", seeds(4))
@pytest.mark.parametrize("model", GROUPS)
def test_fingers_close_on_a_ball_as_far_as_geometry_says(model, seed):
    rng = rng_of(seed)
    radius = rng.uniform(0.006, 0.4 * WIDEST[model])
    off = rng.uniform(-0.8e-3, 0.8e-3)
    world, tool = with_ball(model, radius, [0.0, off, 0.0])
    gripper = gripper_of(world, world.group(GROUPS[model]))
    motion = grasped(world, model, tool)
    assert motion.certificate.proven
    assert motion.trajectory.start == pytest.approx(world.positions(world.group(GROUPS[model])))
    # Both faces are planes across y, as far from the middle as half the width.
    expected = 2 * (radius + abs(off) + GAP)
    # Drake's distances of round shapes are bounded from below by 0.1 mm.
    assert gripper.width(motion.trajectory.end[0]) == pytest.approx(expected, abs=2.1e-4)
    widths = [
        gripper.width(q)
        for [q] in motion.trajectory.positions(np.linspace(0, motion.trajectory.duration, 200))
    ]
    assert min(widths) / 2 - radius - abs(off) >= GAP - 1e-6


@pytest.mark.parametrize("model", GROUPS)
def test_what_one_finger_alone_reaches_is_not_held(model):
    world, tool = with_ball(model, 0.01, [0.0, 3e-3, 0.0])
    with pytest.raises(GraspMissed) as missed:
        grasped(world, model, tool)
    near, far = sorted(missed.value.evidence["distances"])
    assert near == pytest.approx(GAP, abs=1e-4)
    assert far == pytest.approx(GAP + 6e-3, abs=3e-4)
    assert grasped(world, model, tool, reach=0.01).certificate.proven


@pytest.mark.parametrize("model", GROUPS)
def test_a_ball_elsewhere_is_not_held(model):
    for offset in ([0.0, 0.0, 0.3], [0.3, 0.0, 0.0]):
        world, tool = with_ball(model, 0.01, offset)
        with pytest.raises(GraspMissed) as missed:
            grasped(world, model, tool)
        assert missed.value.evidence["distances"] == [None, None]
        assert missed.value.evidence["width"] == 0.0


def test_only_what_is_grasped_may_be_nearer_than_the_margin():
    world, tool = with_ball("ur5e", 0.012, [0.0, 0.0, 0.0])
    margined = planning.GripperCommand(grasp=planning.AttachObject("ball", tool))
    group = GROUPS["ur5e"]
    found = planning.gripper_motion(world, group, margined, deadline=deadline(), margin=0.004)
    assert found.certificate.proven
    gripper = gripper_of(world, world.group(group))
    width = gripper.width(found.trajectory.end[0])
    with pytest.raises(NotCertified):
        planning.gripper_motion(
            world, group, planning.GripperCommand(width=width), deadline=deadline(), margin=0.004
        )
    planning.gripper_motion(
        world, group, planning.GripperCommand(width=width), deadline=deadline(), margin=0.0
    )


def test_a_ball_is_let_go_of_only_where_it_keeps_its_margins():
    world, tool = with_ball("ur5e", 0.012, [0.0, 0.0, 0.0])
    group = GROUPS["ur5e"]
    closed = planning.SetPositions("arm", {"left_finger_joint": 0.01215})
    held = planning.edit_scene(world.scene, [closed, planning.AttachObject("ball", tool)])
    holding = planning.load_world(held)
    for width, margin, is_free in (
        (0.0246, 0.0, True),
        (0.0246, 0.004, False),
        (0.04, 0.004, True),
    ):
        command = planning.GripperCommand(width=width, release=planning.DetachObject("ball"))
        arguments = {"deadline": deadline(), "margin": margin}
        if is_free:
            motion = planning.gripper_motion(holding, group, command, **arguments)
            assert motion.certificate.proven
            continue
        with pytest.raises(NotCertified) as refused:
            planning.gripper_motion(holding, group, command, **arguments)
        assert refused.value.evidence["check"] == "release"
        assert "ball" in refused.value.evidence["pair"]
