"""What the studio says of lengths, proofs, failures and checks, to people who read no code."""

import json
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.studio.api import ShownGroup
from service.studio.motions.checks import words_of
from service.studio.motions.verdict import Proof, verdict_of
from service.studio.plans.failure_words import failed, headline
from service.studio.robots.tracking import unit_of
from service.studio.texts import millimetres
from tests.service.studio.unseen import kind_of, plain

YAML = {"content-type": "application/yaml"}
PICKUP = (Path(__file__).parents[3] / "scenes" / "ur5e_pickup.scene.yaml").read_bytes()


@given(st.floats(1e-9, 10.0))
def test_a_length_that_is_not_zero_is_never_said_to_be(length):
    said = millimetres(length)
    number = float(re.search(r"\d+(\.\d+)?", said)[0])
    if said.startswith("below"):
        assert length < 1e-6
    else:
        assert number / 1000 == pytest.approx(length, rel=0.06)
        assert number > 0
    assert len(said) <= len("below 0.001 mm")


def proof(gap, *, has_margin=False, revision=1):
    certificate = {
        "proven": True,
        "min_clearance": gap,
        "observed_clearance": gap + 0.001,
        "time": 0.92,
        "pair": ["arm::finger", "can"],
    }
    return Proof(certificate, 1.01, revision=revision, has_margin=has_margin)


@given(gap=st.floats(1e-6, 0.1), has_margin=st.booleans(), newest=st.integers(1, 3))
def test_green_is_a_proof_of_the_newest_revision_that_leaves_room(gap, has_margin, newest):
    html = verdict_of(proof(gap, has_margin=has_margin), newest)
    is_narrow = gap < 0.001 and not has_margin
    assert (kind_of(html) == "good") == (newest == 1 and not is_narrow)
    assert ("set a Margin in Options" in html) == (newest == 1 and is_narrow)
    assert ("the scene has changed since" in html) == (newest > 1)


def test_a_proven_bound_and_what_was_measured_are_told_apart():
    said = plain(verdict_of(proof(0.0035), 1))
    assert "at least 3.5 mm clear (4.5 mm measured at 0.92 s) of finger and can" in said


def test_a_goal_that_collides_is_said_in_a_sentence_and_the_rest_is_folded(client):
    scene = client.post("/v1/scenes", content=PICKUP, headers=YAML).json()["id"]
    pose = {"position": [0.5, 0.2, -0.02], "quaternion": [0, 1, 0, 0]}
    body = {"group": "arm", "goal": {"type": "pose", "poses": [pose]}, "ik": {"max_trials": 20}}
    fault = client.post(f"/v1/scenes/{scene}/ik", json=body).json()["failure"]
    evidence = json.loads(json.dumps(fault["evidence"]))
    said = headline(fault["code"], fault["detail"], evidence)
    expected = r"The goal collides( \(all \d+ arm poses\))?\. Least: \w+ with \w+, [\d.]+ mm\."
    assert re.match(expected, said)
    assert re.search(r"Nearest free pose: [\d.]+ mm( and \d+°)? away\.$", said)
    html = failed(fault["code"], fault["detail"], evidence)
    before, _, folded = html.partition("<details")
    assert said in plain(before)
    assert "goal_in_collision" in folded
    assert "e-" not in re.sub(r"[a-z]e-[a-z]", "", plain(folded))


@pytest.mark.parametrize(
    ("code", "detail", "said"),
    [
        (
            "request_invalid",
            "body.operations.1.object.shape.box.0: Input should be greater than 0",
            "Box: Input should be greater than 0",
        ),
        ("other", "arm::wrist hit by 83.7 to 83.7 mm, 3.6e-13 deg away", None),
        ("other", "clearance is -0.0477 m where 0 is the bound", "Clearance is -47.7 mm"),
        ("no_path_found", "", "No path found"),
    ],
)
def test_words_of_the_server_are_made_plain(code, detail, said):
    assert headline(code, detail) == (said or "Wrist hit by 83.7 mm, 0 deg away")


def test_checks_have_meanings_units_and_ticks():
    check = {"bound": 1e-6, "passed": True, "where": "arm::elbow", "time": 1.0}
    near = words_of({**check, "name": "position", "value": -1.32, "unit": "rad or m"})
    assert (near.name, near.value) == ("✓ position limits", "1.32 rad or m to the limit at 1.00 s")
    rest = words_of({**check, "name": "rest", "value": 0.0, "unit": "rad/s or m/s"})
    assert rest.name == "✓ rest at both ends"
    assert "begins and ends at rest" in rest.hint


@pytest.mark.parametrize(
    ("kinds", "unit"),
    [
        (["revolute", "continuous"], "mrad"),
        (["prismatic"], "mm"),
        (["revolute", "prismatic"], "mrad or mm"),
        (["planar"], "mrad or mm"),
    ],
)
def test_an_error_of_tracking_has_the_unit_of_the_joints(kinds, unit):
    group = ShownGroup(
        name="g",
        joints=[{"name": kind, "type": kind} for kind in kinds],
        position_names=[],
        tool_frames=[],
        configurations={},
        limits={"lower": [], "upper": []},
        positions=[],
    )
    assert unit_of(group) == unit
