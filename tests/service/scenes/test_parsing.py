"""Scenes as text: the same scene from either language, and hostile texts refused."""

import json
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.errors import SceneInvalid, WayproofError
from service.errors import UnreadableBody
from service.scenes.document_text import SceneText
from service.scenes.parsing import MAX_DEPTH, decode_scene
from tests.profiles import num_cases, only_campaign

ROBOT = {"name": "arm", "model": "ur5e"}
YAML = """\
name: two
robots:
  - {name: arm, model: ur5e, base: {rpy: [0.1, 0.2, 0.3]}, positions: {elbow_joint: 0.7}}
objects:
  - {name: can, shape: {cylinder: {radius: 0.03, length: 0.1}}, movable: true}
  - {name: floor, shape: {half_space: {}}, color: [0.1, 0.2, 0.3]}
"""


def test_document_gives_the_same_scene_bit_for_bit():
    document = decode_scene(YAML, "yaml")
    again = decode_scene(SceneText.of(document).whole.text, "json")
    assert again.value().digest == document.value().digest
    assert SceneText.of(again) == SceneText.of(document)


@given(st.lists(st.floats(-1e3, 1e3, allow_nan=False), min_size=3, max_size=3))
@settings(max_examples=num_cases(6))
def test_rotations_survive_being_written_and_read(rpy):
    document = {"robots": [{**ROBOT, "base": {"rpy": rpy, "position": rpy}}]}
    posted = decode_scene(json.dumps(document), "json")
    again = decode_scene(SceneText.of(posted).whole.text, "json")
    assert again.value().digest == posted.value().digest


def test_faults_of_yaml_have_lines():
    with pytest.raises(SceneInvalid) as refusal:
        decode_scene("robots:\n  - {name: arm, model: ur5e}\nobjects:\n  - {shape: 1}\n", "yaml")
    assert refusal.value.evidence["line"] == 4


@pytest.mark.parametrize("text", ["{", "[1,", '{"a": }', "", "nonsense", '{"a": 1} x'])
def test_what_is_not_json_is_unreadable(text):
    with pytest.raises(UnreadableBody):
        decode_scene(text, "json")


@pytest.mark.parametrize(
    "text",
    ["[]", "1", "null", '"x"', '{"robots": []}', '{"robots": [], "robots": []}', '{"a": NaN}'],
)
def test_json_that_is_no_scene_is_invalid(text):
    with pytest.raises(SceneInvalid):
        decode_scene(text, "json")


def noise():
    return "".join(random.Random(1).choices('abc{}[]:,"1 \n-', k=600_000))


def keys(count):
    return {f"key{i}": 1 for i in range(count)}


HOSTILE = {
    "noise": ("json", noise),
    "noise in YAML": ("yaml", noise),
    "deep list": ("json", lambda: "[" * 2_000_000),
    "deep object": ("json", lambda: '{"a":' * 1_000_000),
    "balanced and deep": (
        "json", lambda: '{"a":' * (MAX_DEPTH + 1) + "1" + "}" * (MAX_DEPTH + 1),
    ),
    "many keys": ("json", lambda: json.dumps(keys(100_000))),
    "the last key twice": ("json", lambda: json.dumps(keys(100_000))[:-1] + ', "key99999": 1}'),
    "many objects": ("json", lambda: json.dumps({"robots": [ROBOT], "objects": [1] * 1_000_000})),
    "many positions": (
        "json", lambda: json.dumps({"robots": [{**ROBOT, "positions": [""] * 300_000}]}),
    ),
    "long name": ("json", lambda: json.dumps({"robots": [ROBOT], "name": "x" * 5_000_000})),
    "long number": ("json", lambda: '{"margin": ' + "9" * 2_000_000 + "}"),
    "aliases": ("yaml", lambda: "a: &a [x, x]\nb: &b [*a, *a]\nc: &c [*b, *b]\nrobots: *c\n"),
    "many lines": ("yaml", lambda: "".join(f"k{i}: 1\n" for i in range(150_000))),
    "a fault in every line": ("yaml", lambda: "".join(f"k{i}: 1\n" for i in range(25_000))),
    "long flow": ("yaml", lambda: "robots: [" + "1," * 450_000 + "1]"),
}  # fmt: skip


# Work in proportion to the text takes a second; its square takes hours, and the suite's time limit
# ends it.
@only_campaign("9 s")
@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_texts_are_refused_with_work_in_proportion(name):
    media, text = HOSTILE[name]
    with pytest.raises(WayproofError) as refusal:
        decode_scene(text(), media)
    assert len(refusal.value.detail) < 1000
    assert len(json.dumps(refusal.value.evidence)) < 10_000
