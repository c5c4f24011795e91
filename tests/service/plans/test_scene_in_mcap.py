"""A log has the scene in motion: transforms of forward kinematics, markers that follow them."""

import io

import numpy as np
import pytest
import trimesh
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.typesys import Stores, get_typestore

from planning.domain.geometry import rotation
from planning.domain.geometry.pose import Pose
from planning.domain.geometry.shapes import Box, Capsule, Cylinder, Ellipsoid, HalfSpace, Sphere
from planning.domain.scene.geometry import MeshFile, SceneMotion, VisibleBody, VisibleShape
from service.plans.exports.bag import TOPICS
from service.plans.exports.markers import markers
from service.plans.exports.ros_definitions import definition
from tests.profiles import rng_of, seeds

PERIOD = 0.1
STORE = get_typestore(Stores.ROS2_JAZZY)


@pytest.fixture(scope="module")
def log(client, solved):
    answer = client.get(f"/v1/plans/{solved['id']}/trajectory?format=mcap&period={PERIOD}")
    assert answer.status_code == 200, answer.text
    reader = make_reader(io.BytesIO(answer.content), decoder_factories=[DecoderFactory()])
    found = {topic: [] for topic in TOPICS}
    for schema, channel, message, decoded in reader.iter_decoded_messages():
        found[channel.topic].append((schema.name, message, decoded))
    return found


def of(message):
    """A decoded transform as position and rotation."""
    p, q = message.transform.translation, message.transform.rotation
    return np.array([p.x, p.y, p.z]), rotation.matrix(np.array([q.w, q.x, q.y, q.z]))


@pytest.mark.parametrize("name", sorted(set(TOPICS.values())))
def test_definitions_are_those_of_ros_2(name):
    def fields(text):
        kept = [line for line in text.splitlines() if line and "=" not in line.partition(" ")[2]]
        return [
            line.replace("builtin_interfaces/Time", "time").replace(
                "builtin_interfaces/Duration", "duration"
            )
            for line in kept
        ]

    theirs, _ = STORE.generate_msgdef(name.replace("/", "/msg/"))
    ours = definition(name).split("=" * 80)
    by_name = {part.splitlines()[1]: fields(part) for part in ours[1:]}
    for part in theirs.split("=" * 80)[1:]:
        assert by_name[part.splitlines()[1]] == fields(part)
    assert fields(ours[0]) == fields(theirs.split("=" * 80)[0])


def test_ros_2_reads_every_message(log):
    for topic, messages in log.items():
        assert messages, topic
        for schema, message, _ in messages[:3]:
            read = STORE.deserialize_cdr(message.data, schema)
            assert bytes(STORE.serialize_cdr(read, schema)) == bytes(message.data)


def test_transforms_are_those_of_forward_kinematics(client, solved, log):
    scene, motion = solved["request"]["scene"], solved["id"]
    samples = client.get(f"/v1/plans/{motion}/trajectory?period={PERIOD}").json()
    assert len(log["/tf"]) == len(samples["times"])
    names = [each.child_frame_id for each in log["/tf"][0][2].transforms]
    asked = {"group": "arm", "configurations": samples["positions"], "frames": names}
    poses = client.post(f"/v1/scenes/{scene}/fk", json=asked).json()["results"]
    for instant, by_name, (_, message, decoded) in zip(
        samples["times"], poses, log["/tf"], strict=True
    ):
        assert 1e-9 * message.log_time == pytest.approx(instant, abs=1e-9)
        for each in decoded.transforms:
            position, turned = of(each)
            expected = by_name[each.child_frame_id]
            np.testing.assert_allclose(position, expected["position"], atol=1e-9)
            there = rotation.matrix(np.array(expected["quaternion"]))
            np.testing.assert_allclose(turned, there, atol=1e-9)


def test_every_body_has_markers_in_a_frame_of_its_own(client, solved, log):
    scene = solved["request"]["scene"]
    bodies = {body["name"] for body in client.get(f"/v1/scenes/{scene}/geometry").json()["bodies"]}
    ((_, _, drawn),) = log["/markers"]
    ((_, _, fixed),) = log["/tf_static"]
    moving = {each.child_frame_id for each in log["/tf"][0][2].transforms}
    static = {each.child_frame_id for each in fixed.transforms}
    assert not moving & static
    frames = {marker.header.frame_id for marker in drawn.markers}
    assert frames - {"world"} == bodies
    assert frames <= {"world", *moving, *static}
    keys = [(marker.ns, marker.id) for marker in drawn.markers]
    assert len(set(keys)) == len(keys)
    (path,) = (marker for marker in drawn.markers if marker.ns == "tool path")
    assert len(path.points) == len(log["/tf"])


def shown(shape, pose, meshes=None):
    drawn = VisibleShape(shape, pose, np.array([0.1, 0.2, 0.3, 1.0]))
    body = VisibleBody("it", None, (drawn,))
    motion = SceneMotion((body,), {}, {}, np.zeros((0, 3)), meshes or {})
    return markers(motion)


def box_around(marker):
    """Corners of what a marker draws, in the frame of its body."""
    pose = Pose.from_parts(
        [marker["pose"]["position"][axis] for axis in "xyz"],
        [marker["pose"]["orientation"][axis] for axis in "wxyz"],
    )
    if marker["type"] == 11:
        local = np.array([[p[axis] for axis in "xyz"] for p in marker["points"]])
    else:
        half = np.array([marker["scale"][axis] for axis in "xyz"]) / 2
        local = half * np.stack(np.meshgrid(*[[-1, 1]] * 3), axis=-1).reshape(8, 3)
    return local @ rotation.matrix(pose.quaternion).T + pose.position


@pytest.mark.parametrize("seed", seeds(5))
def test_markers_are_as_large_as_their_shapes(seed):
    """In the box of the shape's own axes, wherever the shape is on its body."""
    rng = rng_of(seed)
    a, b, c = rng.uniform(0.05, 1.0, 3)
    pose = Pose.from_parts(rng.uniform(-1, 1, 3), rng.normal(size=4))
    mesh = trimesh.creation.box((a, b, c)).export(file_type="glb")
    sizes = {
        Box(np.array([a, b, c])): (a, b, c),
        Sphere(a): (2 * a, 2 * a, 2 * a),
        Ellipsoid(np.array([a, b, c])): (2 * a, 2 * b, 2 * c),
        Cylinder(a, b): (2 * a, 2 * a, b),
        Capsule(a, b): (2 * a, 2 * a, b + 2 * a),
        MeshFile("it"): (a, b, c),
    }
    for shape, size in sizes.items():
        drawn = shown(shape, pose, {"it": mesh})
        corners = np.concatenate([box_around(marker) for marker in drawn])
        local = (corners - pose.position) @ rotation.matrix(pose.quaternion)
        np.testing.assert_allclose(local.max(axis=0), np.array(size) / 2, atol=1e-6)
        np.testing.assert_allclose(local.min(axis=0), -np.array(size) / 2, atol=1e-6)


def test_a_half_space_is_a_plate_below_its_plane():
    (plate,) = shown(HalfSpace(), Pose.identity())
    corners = box_around(plate)
    assert corners[:, 2].max() == pytest.approx(0.0, abs=1e-12)
    assert corners[:, 2].min() < 0
