"""Scenes written down: read again they are the same."""

from dataclasses import replace

import numpy as np
import pytest

import planning
from planning import AttachObject, MoveObject, Pose, edit_scene, scene_document
from planning.domain.geometry.shapes import Convex
from planning.domain.scene.scene import Scene
from planning.errors import SceneInvalid
from planning.world.documents.scene_document import SceneDocument

SCENES = sorted(planning.bundled_folder("scenes").glob("*.scene.yaml"))
EVERYTHING = planning.parse_scene({
    "name": "everything",
    "robots": [
        {"name": "a", "model": "ur5e", "base": {"rpy": [0.1, 0.2, 0.3]}, "positions": [0.1] * 6},
        {"name": "b", "model": "ur5e", "positions": {"elbow_joint": 1.0}},
    ],
    "objects": [
        {"name": f"o{i}", "shape": shape, "pose": {"rpy": [0.3, 0.1 * i, 0.2]}, "movable": True}
        for i, shape in enumerate([
            {"box": [0.1, 0.2, 0.3]},
            {"sphere": 0.1},
            {"cylinder": {"radius": 0.1, "length": 0.2}},
            {"capsule": {"radius": 0.1, "length": 0.2}},
            {"ellipsoid": [0.1, 0.2, 0.3]},
            {"half_space": {}},
            {"convex": {"points": np.eye(4, 3).tolist()}},
            {"mesh": {"uri": "a.obj", "scale": 2}},
        ])
    ],
    "frames": [{"name": "f", "parent": "o0", "pose": {"rpy": [1, 2, 3]}}],
    "allowed_collisions": [["o0", "o1"]],
    "configurations": {"up": {"group": "a", "positions": [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]}},
    "margin": 0.01,
    "margins": [{"bodies": ["o0", "o2"], "margin": 0.02}],
})


def nearly(a: Scene, b: Scene) -> None:
    """Two scenes differ in nothing but the last bits of quaternions."""
    poses = [[r.base for r in s.robots] + [e.pose for e in (*s.objects, *s.frames)] for s in (a, b)]
    for x, y in zip(*poses, strict=True):
        assert max(x.distance(y)) < 1e-15


@pytest.mark.parametrize("scene", [*map(planning.read_scene, SCENES), EVERYTHING])
def test_what_is_written_is_read_again(scene: Scene) -> None:
    document = scene_document(scene)
    again = document.value()
    nearly(again, scene)
    assert scene_document(again, previous=document) == document
    as_posted = scene_document(scene, previous=document)
    assert as_posted.value() == again


def test_what_is_unchanged_stays_as_it_was_written() -> None:
    posted = SceneDocument.model_validate({
        "robots": [{"name": "arm", "model": "ur5e"}],
        "objects": [
            {"name": "a", "shape": {"sphere": 1}, "pose": {"rpy": [1, 2, 3]}, "movable": True},
            {"name": "b", "shape": {"sphere": 1}, "pose": {"quaternion": [3, 1, 2, 7]}},
        ],
    })
    edited = edit_scene(posted.value(), [MoveObject("a", Pose.from_parts((1, 2, 3)))])
    document = scene_document(edited, previous=posted)
    assert document.objects[1] == posted.objects[1]
    assert document.value() == edited


def test_a_revised_document_may_have_no_more_than_any() -> None:
    posted = SceneDocument.model_validate({
        "robots": [{"name": "arm", "model": "ur5e"}],
        "objects": [{"name": "o", "shape": {"sphere": 1}}],
    })
    before = posted.value()
    many = tuple(replace(before.objects[0], name=f"o{i}") for i in range(10_001))
    with pytest.raises(SceneInvalid, match="at most 10000"):
        scene_document(replace(before, objects=many), previous=posted)


def test_attachments_are_written() -> None:
    scene = edit_scene(EVERYTHING, [AttachObject("o1", "b::tcp", ("o2", "a::tcp"))])
    attached = scene_document(scene).objects[1].attached
    assert attached is not None
    assert attached.value() == scene.objects[1].attached


def test_what_no_document_may_have_is_refused() -> None:
    flat = replace(EVERYTHING.objects[0], shape=Convex(np.zeros((4, 3))))
    with pytest.raises(SceneInvalid):
        scene_document(replace(EVERYTHING, objects=(flat,)))
