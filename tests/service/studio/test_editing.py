"""Edits by hand: what takes them back, sizes, and where live robots are."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.studio.api import ShownGroup
from service.studio.editing.history import (
    SHAPES,
    inverse,
    new_object,
    object_of,
    replacement,
)
from service.studio.editing.sizes import sizes_of, with_size
from service.studio.robots.live import positions_of

PICKUP = (Path(__file__).parents[3] / "scenes" / "ur5e_pickup.scene.yaml").read_bytes()
YAML = {"content-type": "application/yaml"}


def by_name(document):
    """A document whose lists have no order; poses and colours have all that they can have."""
    pairs = sorted(sorted(pair) for pair in document["allowed_collisions"])
    upright = {"quaternion": [1.0, 0.0, 0.0, 0.0]}
    objects = [
        {**entry, "pose": upright | entry["pose"], "color": (*entry["color"], 1.0)[:4]}
        for entry in document["objects"]
    ]
    objects.sort(key=lambda entry: entry["name"])
    return {**document, "objects": objects, "allowed_collisions": pairs}


def test_what_was_done_to_a_scene_is_undone_by_its_inverse(client):
    scene = client.post("/v1/scenes", content=PICKUP, headers=YAML).json()
    address = f"/v1/scenes/{scene['id']}"

    def carry_out(operations):
        answer = client.patch(address, json={"operations": operations})
        assert answer.status_code == 200, answer.text
        return answer.json()["document"]

    first = scene["document"]
    larger = with_size(object_of(first, "table"), [1.0, 1.0, 0.04])
    edits = [
        [{"op": "add", "object": new_object(first, kind, [0.4, -0.4, 0.3])} for kind in SHAPES],
        [{"op": "move", "object": "box", "pose": {"position": [0.5, 0.1, 0.14]}}],
        replacement(first, "table", larger),
        [{"op": "remove", "object": "box"}],
    ]
    for operations in edits:
        document = carry_out(operations)
        assert by_name(document) != by_name(first)
        assert by_name(carry_out(inverse(first, operations))) == by_name(first)


def test_an_object_with_frames_keeps_its_size(client):
    document = client.post("/v1/scenes", content=PICKUP, headers=YAML).json()["document"]
    with pytest.raises(ValueError, match="pick would be lost with can"):
        replacement(document, "can", object_of(document, "can"))


def test_new_objects_have_names_that_are_free():
    document = {"objects": [{"name": "box_1"}], "robots": [{"name": "box_2"}]}
    assert new_object(document, "box", [0, 0, 0])["name"] == "box_3"


@given(st.sampled_from(sorted(SHAPES)), st.lists(st.floats(0.01, 1.0), min_size=3, max_size=3))
def test_sizes_that_are_set_are_those_it_has(kind, values):
    entry = {"name": "x", "shape": SHAPES[kind]}
    values = values[: len(sizes_of(entry))]
    assert list(sizes_of(with_size(entry, values)).values()) == values
    assert entry["shape"] == SHAPES[kind]
    assert sizes_of({"shape": {"half_space": {}}}) == {}


def test_live_positions_are_those_of_the_group_in_its_order():
    names = ["base::pose.x", "base::pose.y", "base::pose.theta", "base::lift"]
    limits = {"lower": [None] * 4, "upper": [None] * 4}
    group = ShownGroup(
        name="base",
        position_names=names,
        tool_frames=[],
        configurations={},
        limits=limits,
        positions=[0.0] * 4,
    )
    found = positions_of(group, {"lift": 0.5, "finger": 0.1, "pose": [1.0, 2.0, 3.0]})
    np.testing.assert_array_equal(found, [1.0, 2.0, 3.0, 0.5])
