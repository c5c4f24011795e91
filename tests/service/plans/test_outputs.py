"""Delivered motions: sampled anew, slowed, exact, replayed."""

import csv
import io
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from service.plans.models.trajectory import Polynomial
from tests.profiles import only_campaign


def trajectory(client, job, query=""):
    answer = client.get(f"/v1/plans/{job['id']}/trajectory{query}")
    assert answer.status_code == 200, answer.text
    return answer


def test_the_default_is_what_the_plan_delivered(client, solved):
    assert trajectory(client, solved).json() == solved["result"]["trajectory"]


@pytest.mark.parametrize("scale", [0.25, 0.5, 1.0])
def test_scale_slows_the_same_motion(client, solved, scale):
    exact = trajectory(client, solved, "?polynomial=true").json()
    motion = Polynomial.model_validate(exact["polynomial"]).to_domain()
    slow = trajectory(client, solved, f"?scale={scale}&period={0.01 / scale}").json()
    assert slow["duration"] == pytest.approx(motion.duration / scale)
    times = np.array(slow["times"]) * scale
    np.testing.assert_allclose(slow["positions"], motion.positions(times), atol=1e-7)
    rates = motion.velocities(times) * scale
    np.testing.assert_allclose(slow["velocities"], rates, atol=1e-6)
    # On a break the piece before it is as right.
    bends = [motion.accelerations(times + side) * scale**2 for side in (-1e-9, 1e-9)]
    off = np.min([np.abs(slow["accelerations"] - bend) for bend in bends], axis=0)
    np.testing.assert_allclose(off, 0.0, atol=1e-5)
    assert all(proof["proven"] for proof in slow["interpolations"])


@pytest.mark.parametrize("count", [2, 3, 101])
def test_as_many_points_as_asked_for_evenly_in_time(client, solved, count):
    motion = trajectory(client, solved, f"?points={count}&scale=0.5").json()
    duration = solved["result"]["trajectory"]["duration"] / 0.5
    assert motion["duration"] == pytest.approx(duration)
    np.testing.assert_allclose(motion["times"], np.linspace(0, duration, count))
    whole = solved["result"]["trajectory"]["positions"]
    np.testing.assert_allclose(motion["positions"][0], whole[0], atol=1e-9)
    np.testing.assert_allclose(motion["positions"][-1], whole[-1], atol=1e-9)
    table = trajectory(client, solved, f"?points={count}&format=csv").text
    assert len(table.splitlines()) == count + 1


@pytest.mark.parametrize("query", ["points=5&period=0.1", "points=1", "points=200001"])
def test_points_that_cannot_be_meant_are_refused(client, solved, query):
    answer = client.get(f"/v1/plans/{solved['id']}/trajectory?{query}")
    assert answer.status_code == 422


def test_csv_has_the_same_numbers(client, solved):
    answer = trajectory(client, solved, "?format=csv&period=0.1")
    assert answer.headers["content-type"].startswith("text/csv")
    header, *rows = list(csv.reader(io.StringIO(answer.text)))
    motion = trajectory(client, solved, "?period=0.1").json()
    assert header[0] == "time"
    assert header[1] == f"position:{motion['joint_names'][0]}"
    numbers = np.array(rows, dtype=float)
    columns = [np.array(motion["times"])[:, None], motion["positions"], motion["velocities"]]
    expected = np.hstack([*columns, motion["accelerations"]])
    np.testing.assert_array_equal(numbers, expected)


def test_the_polynomial_is_the_motion(client, solved):
    exact = trajectory(client, solved, "?polynomial=true&period=0.05").json()
    pieces = exact["polynomial"]
    breaks = np.array(pieces["breaks"])
    for time, q in zip(exact["times"], exact["positions"], strict=True):
        i = min(np.searchsorted(breaks, time, side="right"), len(breaks) - 1) - 1
        powers = (time - breaks[i]) ** np.arange(len(pieces["coefficients"][i]))
        np.testing.assert_allclose(
            pieces["bases"][i] + powers @ pieces["coefficients"][i], q, atol=1e-7
        )
    assert trajectory(client, solved).json()["polynomial"] is None


def test_too_many_samples_are_refused(client, solved):
    answer = client.get(f"/v1/plans/{solved['id']}/trajectory?period=0.0001&scale=0.002")
    assert answer.status_code == 422
    assert answer.json()["code"] == "problem_invalid"
    assert "points" in answer.json()["detail"]


def test_a_plan_is_as_slow_as_it_likes_if_its_samples_are_few(client, scene):
    request = {"scene": scene, "group": "arm", "goal": {"type": "configuration", "name": "ready"}}
    request["search"] = {"allowed_planning_time": 60.0}
    retime = {"velocity_scale": 1e-9}
    job = client.post("/v1/plans?wait=60", json={**request, "retime": retime}).json()
    assert (job["state"], job["failure"]["code"]) == ("failed", "problem_invalid")
    assert "retime.num_points" in job["failure"]["detail"]
    retime["num_points"] = 20
    job = client.post("/v1/plans?wait=60", json={**request, "retime": retime}).json()
    assert job["state"] == "succeeded", job["failure"]
    back = client.post(f"/v1/plans/{job['id']}/reverse?wait=60").json()
    assert len(back["result"]["trajectory"]["times"]) == 20
    assert len(trajectory(client, job).json()["times"]) == 20
    again = {**job["request"], "retime": {**job["request"]["retime"], "velocity_scale": 1.0}}
    assert client.post("/v1/plans", json=again).status_code == 202


def test_the_replay_is_a_page_by_itself(client, solved):
    answer = client.get(f"/v1/plans/{solved['id']}/replay.html")
    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith("text/html")
    assert "meshcat" in answer.text.lower()
    assert len(answer.content) > 100_000


JOINT_CHARTS = ["acceleration", "jerk", "position", "torque", "velocity"]
CHARTS = [*JOINT_CHARTS, "clearance", "tool_speed", "utilisation"]
# Drawn by tests/service/plans/test_charts.py and by test_torque.py as well.
DRAWN = {"acceleration", "torque"}
FURTHER = only_campaign("half a second each")


@pytest.mark.campaign
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[FURTHER] if name in DRAWN else []) for name in CHARTS]
)
def test_plots_are_drawings_of_every_joint(client, solved, name):
    answer = client.get(f"/v1/plans/{solved['id']}/plots/{name}.svg")
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == "image/svg+xml"
    drawing = ET.fromstring(answer.text)
    words = {text for element in drawing.iter() for text in [element.text] if text}
    assert "time [s]" in words
    if name in JOINT_CHARTS:
        joints = solved["result"]["trajectory"]["joint_names"]
        assert {joint.partition("::")[2] for joint in joints} <= words
    if name == "velocity":
        assert client.get(f"/v1/plans/{solved['id']}/plots/{name}.svg").text == answer.text


def test_there_is_no_other_plot(client, solved):
    assert client.get(f"/v1/plans/{solved['id']}/plots/smell.svg").status_code == 422


def test_the_series_is_the_motion_within_its_limits(client, solved):
    answer = client.get(f"/v1/plans/{solved['id']}/series?points=41")
    assert answer.status_code == 200, answer.text
    series = answer.json()
    exact = trajectory(client, solved, "?polynomial=true").json()
    motion = Polynomial.model_validate(exact["polynomial"]).to_domain()
    times = np.linspace(0.0, motion.duration, 41)
    np.testing.assert_allclose(series["times"], times, atol=1e-12)
    np.testing.assert_allclose(series["positions"], motion.positions(times), atol=1e-12)
    np.testing.assert_allclose(series["velocities"], motion.velocities(times), atol=1e-12)
    np.testing.assert_allclose(series["accelerations"], motion.accelerations(times), atol=1e-12)
    rows = {"velocity": "velocities", "acceleration": "accelerations", "torque": "torques"}
    for limit, values in rows.items():
        bound = np.array(series["limits"][limit]["upper"])
        used = (np.abs(series[values]) / bound).max(axis=1)
        np.testing.assert_allclose(series["utilisation"][limit], used, atol=1e-9)
    assert np.max(series["utilisation"]["acceleration"]) < 1 + 1e-6
    assert "jerk" not in series["limits"]  # toppra does not limit it
    assert series["clearance"] is None
    assert series["closest_pairs"] is None


def test_the_series_has_distances_if_asked(client, solved):
    series = client.get(f"/v1/plans/{solved['id']}/series?points=5&distances=true").json()
    positions = {"group": "arm", "configurations": series["positions"]}
    verdicts = client.post(f"/v1/scenes/{solved['request']['scene']}/check", json=positions)
    measured = [verdict["distance"] for verdict in verdicts.json()["results"]]
    np.testing.assert_allclose(series["clearance"], measured, atol=1e-3)
    assert all(len(pair) == 2 for pair in series["closest_pairs"])
    assert client.get(f"/v1/plans/{solved['id']}/series?points=1").status_code == 422
