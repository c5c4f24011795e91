"""Pages of failures, scenes and plans: complete in themselves, and with what they are about."""

import io
import json
import re
from base64 import b64decode
from html.parser import HTMLParser

import numpy as np
import pytest
from PIL import Image

from planning.world.replay.replay_page import labelled
from service.plans.delivery.failure_worker import shown_configuration
from service.plans.delivery.picture_worker import shown_instants
from service.plans.delivery.report import report_html
from service.plans.models.plan import PlanSummary
from service.plans.models.request import PlanRequest
from service.plans.tasks import PictureWork


@pytest.fixture(scope="module")
def blocked(client, scene):
    """A plan that failed: at its goal the hand is in the post."""
    goal = {"type": "joint", "positions": [0.0] * 6}
    request = {"scene": scene, "group": "arm", "goal": goal}
    job = client.post("/v1/plans?wait=60", json=request).json()
    assert (job["state"], job["failure"]["code"]) == ("failed", "goal_in_collision")
    return job


def page(client, path):
    answer = client.get(path)
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"].startswith("text/html")
    assert not re.findall(
        r"""<(?:script|link|img|iframe)[^>]*(?:src|href)\s*=\s*(?!"data:)""", answer.text
    )
    return answer.text


def told(text):
    """What the script of a 3-D page is told."""
    return json.loads(re.search(r"const told = (\{.*\});$", text, re.MULTILINE)[1])


def test_a_failure_shows_the_pair_and_says_why(client, blocked):
    text = page(client, f"/v1/plans/{blocked['id']}/failure.html")
    shown = told(text)
    assert shown["title"] == f"{blocked['id']}: goal_in_collision"
    assert shown["notes"][0] == blocked["failure"]["detail"]
    assert any("post" in note and "overlap by" in note for note in shown["notes"])
    assert "Shown: the goal, where it is least infeasible." in shown["notes"]
    # Links in red have their names, others on request.
    kinds = {label["text"]: label["kind"] for label in shown["labels"]}
    in_red = {name for note in shown["notes"][1:] for name in re.findall(r"arm::(\w+)", note)}
    assert in_red
    assert {kinds[name] for name in in_red} == {"thing"}
    assert kinds["base_link"] == "link"
    # The nearest feasible configuration is drawn as a ghost, if there is one.
    has_ghost = blocked["failure"]["evidence"]["nearest"] is not None
    assert any("Green" in note for note in shown["notes"]) == has_ghost


def test_a_start_in_collision_is_shown_where_it_starts(client, scene):
    request = {"scene": scene, "group": "arm", "start": [0.0] * 6}
    request["goal"] = {"type": "configuration", "name": "ready"}
    job = client.post("/v1/plans?wait=60", json=request).json()
    assert job["failure"]["code"] == "start_in_collision"
    shown = told(page(client, f"/v1/plans/{job['id']}/failure.html"))
    assert "Shown: the start." in shown["notes"]
    assert any("overlap by" in note for note in shown["notes"])


def test_a_motion_that_is_not_certified_is_shown_where_its_check_fails(client, scene):
    request = {"scene": scene, "group": "arm", "certify": {"max_stopping_time": 1e-4}}
    request["goal"] = {"type": "configuration", "name": "ready"}
    job = client.post("/v1/plans?wait=60", json=request).json()
    (check,) = job["failure"]["evidence"]["checks"]
    assert (job["failure"]["code"], check["name"]) == ("not_certified", "stop")
    shown = told(page(client, f"/v1/plans/{job['id']}/failure.html"))
    assert f"Shown: the motion at {check['time']:.3f} s, where stop fails." in shown["notes"]
    _, positions = shown_configuration(PlanRequest.model_validate(request), job["failure"], 6)
    assert positions.tolist() == check["positions"]
    at_rest = client.get(f"/v1/scenes/{scene}").json()["groups"][0]["positions"]
    assert check["positions"] != at_rest


def test_a_goal_out_of_reach_is_shown_with_the_nearest_pose(client, scene):
    goal = {"type": "pose", "poses": [{"position": [0.0, 0.0, 3.0]}]}
    request = {"scene": scene, "group": "arm", "goal": goal}
    job = client.post("/v1/plans?wait=60", json=request).json()
    assert job["failure"]["code"] == "goal_unreachable"
    shown = told(page(client, f"/v1/plans/{job['id']}/failure.html"))
    assert {"text": "goal", "kind": "frame", "path": "/target/2"} in shown["labels"]
    assert {"Large axes: the goal.", "Green: the nearest feasible configuration."} <= {
        *shown["notes"]
    }


def test_a_plan_without_a_failure_has_no_picture_of_it(client, solved):
    answer = client.get(f"/v1/plans/{solved['id']}/failure.html")
    assert (answer.status_code, answer.json()["code"]) == (409, "no_trajectory")


def test_a_scene_is_shown_without_a_motion(client, scene):
    shown = told(page(client, f"/v1/scenes/{scene}/view.html"))
    assert shown["title"] == "block"
    assert {"block", "post", "above"} <= {label["text"] for label in shown["labels"]}
    assert shown["sections"] == shown["tracks"] == []
    assert client.get("/v1/scenes/scn_0/view.html").status_code == 404


def test_a_replay_has_a_curve_for_each_joint(client, solved):
    shown = told(page(client, f"/v1/plans/{solved['id']}/replay.html"))
    trajectory = solved["result"]["trajectory"]
    assert [track["name"] for track in shown["tracks"]] == trajectory["joint_names"]
    for k, track in enumerate(shown["tracks"]):
        assert track["times"][-1] == pytest.approx(trajectory["duration"], abs=1e-3)
        ends = [trajectory["positions"][0][k], trajectory["positions"][-1][k]]
        assert [track["values"][0], track["values"][-1]] == pytest.approx(ends, abs=1e-4)


class _Text(HTMLParser):
    """Collects text, and refuses tags that do not match."""

    def __init__(self):
        super().__init__()
        self.open, self.text, self.drawings, self.pictures = [], [], 0, []

    def handle_starttag(self, tag, attrs):
        self.drawings += tag == "svg"
        if tag == "img":
            self.pictures.append(dict(attrs))
        if tag not in {"meta", "path", "use", "rect", "image", "img"}:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag not in {"meta", "path", "use", "rect", "image"}:
            assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def read(text):
    parser = _Text()
    parser.feed(text)
    assert parser.open == []
    return " ".join(parser.text), parser.drawings, parser.pictures


def test_a_report_has_request_versions_certificate_and_charts(client, solved):
    text, drawings, pictures = read(page(client, f"/v1/plans/{solved['id']}/report.html"))
    assert solved["digest"] in text
    assert drawings == 6
    for check in solved["result"]["certificate"]["checks"]:
        assert check["name"] in text
    for name, version in solved["versions"].items():
        assert f"{name} {version}" in text
    assert '"allowed_planning_time": 60.0' in text
    shown = [decoded(picture["src"]) for picture in pictures]
    assert [picture.shape for picture in shown] == [(330, 420, 3)] * 3
    captions = [picture["alt"] for picture in pictures]
    assert all(caption in text for caption in captions)
    certificate = solved["result"]["certificate"]
    # the robot is elsewhere at the goal, and red where it is narrowest
    assert (np.abs(shown[0] - shown[2]).max(axis=2) > 60).mean() > 0.02
    (narrowest,) = (i for i, caption in enumerate(captions) if "arrowest" in caption)
    assert f"{certificate['time']:.2f} s" in captions[narrowest]
    others = [is_red(shown[i]).sum() for i in range(3) if i != narrowest]
    assert is_red(shown[narrowest]).sum() > max(others) + 200


def test_a_report_without_time_for_pictures_says_so(solved):
    plan = PlanSummary.model_validate({name: solved[name] for name in PlanSummary.model_fields})
    text, _, pictures = read(report_html(plan, solved["result"], {}, None))
    assert pictures == []
    assert "not enough time to draw pictures" in text
    assert solved["digest"] in text


def decoded(address):
    """The picture in an address of its own, shape (height, width, 3)."""
    head, _, content = address.partition(",")
    assert head == "data:image/png;base64"
    return np.asarray(Image.open(io.BytesIO(b64decode(content)))).astype(int)


def is_red(picture):
    return (picture[..., 0] > 90) & (picture[..., 0] > 1.8 * picture[..., 1:].max(axis=2))


@pytest.mark.parametrize(
    ("nearest", "place", "words"),
    [
        (0.0, 0, "The start, 0.00 s, and narrowest: hand and post"),
        (0.7, 1, "Narrowest, at 0.70 s: hand and post"),
        (2.0, 2, "The goal, 2.00 s, and narrowest: hand and post"),
        (None, None, None),
    ],
)
def test_the_narrowest_place_is_marked_once(nearest, place, words):
    pair = [] if nearest is None else ["arm::hand", "post"]
    work = PictureWork.model_construct(nearest_at=nearest, pair=pair, points=[[0, 0, 0], [0, 0, 1]])
    shown = shown_instants(work, 2.0)
    times = [instant.time for _, instant in shown]
    assert times == [0.0, nearest if place == 1 else 1.0, 2.0]
    marked = [i for i, (_, instant) in enumerate(shown) if instant.marked]
    assert marked == ([] if place is None else [place])
    if place is not None:
        assert shown[place][0] == words
        assert shown[place][1].segment.shape == (2, 3)


def test_a_report_of_a_failure_says_why(client, blocked):
    text, drawings, pictures = read(page(client, f"/v1/plans/{blocked['id']}/report.html"))
    assert (drawings, pictures) == (0, [])
    assert blocked["failure"]["detail"] in text


def test_no_text_ends_the_script():
    evil = "</script><script>alert(1)</script>"
    text = labelled("<title>Drake MeshCat</title><body></body>", evil, [], notes=[evil])
    assert evil not in text
    assert told(text)["notes"] == [evil]
