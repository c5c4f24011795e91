"""Files of other programs have the numbers of the samples: each is read by what reads it."""

import io
import json
import re

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.typesys import Stores, get_typestore

from planning.errors import ProblemInvalid
from service.plans.exports import formats
from service.plans.exports.formats import FORMATS, require_format

FORMAT = list(FORMATS)


def exported(client, job, name, query="&period=0.05"):
    answer = client.get(f"/v1/plans/{job['id']}/trajectory?format={name}{query}")
    assert answer.status_code == 200, answer.text
    return answer


@pytest.fixture(scope="module")
def motion(client, solved):
    return client.get(f"/v1/plans/{solved['id']}/trajectory?period=0.05").json()


@pytest.mark.parametrize("name", [name for name in FORMAT if name != "rerun"])
def test_a_file_says_what_it_is_and_what_is_proven(client, solved, name):
    answer = exported(client, solved, name)
    assert answer.headers["content-type"].split(";")[0] == FORMATS[name].media_type
    assert answer.headers["wayproof-interpolation"].startswith("linear=proven")
    slow = exported(client, solved, name, "&period=0.05&scale=0.5")
    assert len(slow.content) > len(answer.content)


def test_numpy_reads_its_arrays(client, solved, motion):
    with np.load(io.BytesIO(exported(client, solved, "npz").content), allow_pickle=False) as read:
        assert read["joint_names"].tolist() == motion["joint_names"]
        for name in ("times", "positions", "velocities", "accelerations"):
            np.testing.assert_array_equal(read[name], motion[name])


def message_of(store, kind, fields):
    """A message of ROS 2 of its fields by name, none left out and none too many."""
    types = {
        "std_msgs/msg/Header": ["stamp"],
        "trajectory_msgs/msg/JointTrajectory": ["header", "points"],
        "trajectory_msgs/msg/JointTrajectoryPoint": ["time_from_start"],
    }
    inner = {
        "stamp": "builtin_interfaces/msg/Time",
        "header": "std_msgs/msg/Header",
        "time_from_start": "builtin_interfaces/msg/Duration",
    }
    made = {}
    for name, value in fields.items():
        if name == "points":
            point = "trajectory_msgs/msg/JointTrajectoryPoint"
            made[name] = [message_of(store, point, one) for one in value]
        elif name in types.get(kind, ()):
            made[name] = message_of(store, inner[name], value)
        elif isinstance(value, list) and name != "joint_names":
            made[name] = np.array(value, dtype=np.float64)
        else:
            made[name] = value
    return store.types[kind](**made)


def test_ros_reads_its_message(client, solved, motion):
    store = get_typestore(Stores.ROS2_JAZZY)
    kind = "trajectory_msgs/msg/JointTrajectory"
    fields = json.loads(exported(client, solved, "ros2").content)
    data = store.serialize_cdr(message_of(store, kind, fields), kind)
    read = store.deserialize_cdr(data, kind)
    assert read.joint_names == motion["joint_names"]
    for name in ("positions", "velocities", "accelerations"):
        rows = [getattr(point, name) for point in read.points]
        np.testing.assert_array_equal(rows, motion[name])
    times = [
        point.time_from_start.sec + 1e-9 * point.time_from_start.nanosec for point in read.points
    ]
    np.testing.assert_allclose(times, motion["times"], atol=1e-9)


def test_mcap_reads_its_log(client, solved, motion):
    file = io.BytesIO(exported(client, solved, "mcap").content)
    log = make_reader(file, decoder_factories=[DecoderFactory()])
    read = list(log.iter_decoded_messages())
    (whole,) = (one for _, channel, _, one in read if channel.topic == "/joint_trajectory")
    assert whole.joint_names == motion["joint_names"]
    np.testing.assert_array_equal(whole.points[-1].positions, motion["positions"][-1])
    states = [
        (message.log_time, one)
        for _, channel, message, one in read
        if channel.topic == "/joint_states"
    ]
    np.testing.assert_array_equal([one.position for _, one in states], motion["positions"])
    np.testing.assert_array_equal([one.velocity for _, one in states], motion["velocities"])
    np.testing.assert_allclose([1e-9 * at for at, _ in states], motion["times"], atol=1e-9)


def test_a_program_of_universal_robots_goes_through_the_samples(client, solved, motion):
    text = exported(client, solved, "urscript").text
    assert text.count("\n  end\n") == 1
    assert text.startswith("def wayproof_motion():\n")
    assert text.endswith("stopj(2.0)\nend\n")
    start = json.loads(re.search(r"start = (\[.*\])", text)[1])
    np.testing.assert_allclose(start, motion["positions"][0], atol=1e-9)
    found = re.findall(r"^  servoj\((\[.*\]), 0, 0, t=([\d.]+), ", text, re.MULTILINE)
    rows, steps = zip(*found, strict=True)
    np.testing.assert_allclose(
        [json.loads(row) for row in rows], motion["positions"][1:], atol=1e-9
    )
    np.testing.assert_allclose([float(step) for step in steps], np.diff(motion["times"]), atol=1e-6)
    assert "movej" not in text


@pytest.mark.parametrize(
    ("name", "types", "word"),
    [
        ("ros2", ["revolute", "planar"], "planar or floating"),
        ("mcap", ["floating"], "planar or floating"),
        ("urscript", ["revolute"] * 7, "six revolute joints"),
        ("urscript", ["revolute"] * 5 + ["prismatic"], "six revolute joints"),
    ],
)
def test_what_a_format_cannot_hold_is_refused(name, types, word):
    with pytest.raises(ProblemInvalid, match=word) as refusal:
        require_format(name, types)
    assert refusal.value.evidence == {"field": "format"}
    require_format("npz", types)


@pytest.mark.parametrize("name", ["mcap", "rerun"])
def test_a_server_without_an_extra_says_so(monkeypatch, name):
    monkeypatch.setattr(formats, "_MODULES", {name: "no_such_module"})
    with pytest.raises(ProblemInvalid, match=f"extra `{name}`"):
        require_format(name, ["revolute"])
