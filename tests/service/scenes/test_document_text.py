"""What an edit writes in part is what would be written as a whole."""

import json
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning import (
    AddObject,
    MoveObject,
    Pose,
    RemoveObject,
    SetPositions,
    edit_scene,
    scene_document,
)
from planning.world.documents.scene_document import SceneDocument
from service.scenes import document_text as scene_text
from service.scenes.document_text import SceneText, keep_text, kept_text
from service.scenes.parsing import decode_scene
from tests.profiles import num_cases

POSTED = SceneDocument.model_validate({
    "robots": [{"name": "arm", "model": "ur5e", "base": {"rpy": [0.1, 0.2, 0.3]}}],
    "objects": [
        {"name": f"o{i}", "shape": {"box": [1, 1, 1 + i]}, "pose": {"rpy": [i, 2, 3]}}
        for i in range(4)
    ],
    "frames": [{"name": "f", "parent": "o1", "pose": {"rpy": [1, 2, 3]}}],
    "margin": 0.02,
})
names = st.sampled_from(["o0", "o1", "o2", "o3", "new"])
angle = st.floats(-3.0, 3.0)
poses = st.builds(
    Pose.from_parts, st.tuples(angle, angle, angle), rpy=st.tuples(angle, angle, angle)
)
things = st.builds(replace, st.just(POSTED.value().objects[0]), name=names, pose=poses)
operations = st.one_of(
    st.builds(MoveObject, names, poses),
    st.builds(AddObject, things),
    st.builds(RemoveObject, names),
    st.builds(SetPositions, st.just("arm"), st.tuples(*[angle] * 6)),
)


def is_possible(scene, operation):
    there = {thing.name for thing in scene.objects}
    match operation:
        case AddObject(thing):
            return thing.name not in there
        case MoveObject(name) | RemoveObject(name):
            return name in there
    return True


@given(edits=st.lists(st.lists(operations, min_size=1, max_size=3), min_size=1, max_size=4))
@settings(max_examples=num_cases(10), deadline=None)
def test_scenes_that_are_edited_in_part_are_those_that_are_posted_whole(edits):
    text, scene, whole = SceneText.of(POSTED), POSTED.value(), POSTED
    for edit in edits:
        before = scene
        for operation in edit:
            if is_possible(scene, operation):
                scene = edit_scene(scene, [operation])
        whole = scene_document(scene, previous=whole)
        text, after = text.after(before, scene)
        kept = {thing.name: thing for thing in before.objects}
        assert all(kept[t.name] is t for t in after.objects if kept.get(t.name) == t)
        scene = after
        plain = whole.model_dump(mode="json", exclude_none=True)
        assert json.loads(text.whole.text) == plain
        assert list(json.loads(text.whole.text)) == list(plain)
        posted = decode_scene(text.whole.text, "json")
        assert posted.value().digest == scene.digest == whole.value().digest
        assert SceneText.of(posted).whole == text.whole


def test_what_no_document_may_say_has_no_text():
    scene = POSTED.value()
    wide = replace(scene.objects[0], pose=Pose.from_parts((2e6, 0, 0)))
    many = tuple(replace(scene.objects[0], name=f"o{i}") for i in range(10_001))
    for objects in ((wide,), many):
        assert SceneText.of(POSTED).after(scene, replace(scene, objects=objects)) is None


def test_the_texts_used_last_are_kept(monkeypatch):
    monkeypatch.setattr(scene_text, "_recent", type(scene_text._recent)())
    texts = [SceneText.of(POSTED.model_copy(update={"name": f"s{i}"})) for i in range(9)]
    for i, text in enumerate(texts):
        keep_text(f"d{i}", text)
        assert kept_text("d0") is (texts[0] if i < 8 else None)
    assert [kept_text(f"d{i}") for i in range(1, 9)] == texts[1:]


@pytest.mark.parametrize("name", ["\u00fc/\u6c34", 'a"b\\c', "line\nline"])
def test_paths_of_all_kinds_are_written_on_one_line_of_ascii(name):
    document = POSTED.model_copy(
        update={"robots": [POSTED.robots[0].model_copy(update={"model": name})]}
    )
    text = SceneText.of(document).whole.text
    assert text.isascii()
    assert "\n" not in text
    assert json.loads(text)["robots"][0]["model"] == name
