"""A recording has the scene in motion as forward kinematics says, read back by Rerun itself."""

import numpy as np
import pytest
from rerun.chunk import RrdReader

PERIOD = 0.1


@pytest.fixture(scope="module")
def chunks(client, solved, tmp_path_factory):
    """Columns of a recording by place in its tree and by whether they are static."""
    answer = client.get(f"/v1/plans/{solved['id']}/trajectory?format=rerun&period={PERIOD}")
    assert answer.status_code == 200, answer.text
    assert answer.headers["content-type"] == "application/x-rerun"
    file = tmp_path_factory.mktemp("rerun") / "motion.rrd"
    file.write_bytes(answer.content)
    found = {}
    for chunk in RrdReader(file).stream():
        place = chunk.entity_path.replace("\\", "")
        columns = found.setdefault((place, chunk.is_static), {})
        batch = chunk.to_record_batch()
        columns |= dict(zip(batch.schema.names, batch.columns, strict=True))
    return found


@pytest.fixture(scope="module")
def samples(client, solved):
    return client.get(f"/v1/plans/{solved['id']}/trajectory?period={PERIOD}").json()


def numbers(column, *shape):
    while hasattr(column, "flatten") and hasattr(column.type, "value_type"):
        column = column.flatten()
    return np.asarray(column).reshape(-1, *shape)


def test_bodies_move_as_forward_kinematics_says(client, solved, chunks, samples):
    bodies = [name.removeprefix("/world/") for name, static in chunks if not static]
    links = [name for name in bodies if not name.startswith("/joints")]
    assert len(links) >= 6
    asked = {"group": "arm", "configurations": samples["positions"], "frames": links}
    scene = solved["request"]["scene"]
    poses = client.post(f"/v1/scenes/{scene}/fk", json=asked).json()["results"]
    for link in links:
        moved = chunks[f"/world/{link}", False]
        expected = [by_name[link]["position"] for by_name in poses]
        np.testing.assert_allclose(
            numbers(moved["Transform3D:translation"], 3), expected, atol=1e-6
        )
        times = np.asarray(moved["time"]).astype("timedelta64[ns]").astype(np.int64) / 1e9
        np.testing.assert_allclose(times, samples["times"], atol=1e-9)


def test_every_shape_is_drawn(client, solved, chunks):
    scene = solved["request"]["scene"]
    for body in client.get(f"/v1/scenes/{scene}/geometry").json()["bodies"]:
        for i, _ in enumerate(body["shapes"]):
            columns = chunks[f"/world/{body['name']}/{i}", True]
            assert any(name.split(":")[0].endswith("3D") for name in columns), columns.keys()
            assert "Transform3D:translation" in columns


def test_curves_have_every_joint(chunks, samples):
    rows = {"position": samples["positions"], "velocity": samples["velocities"]}
    for kind, values in rows.items():
        for k, name in enumerate(samples["joint_names"]):
            curve = chunks[f"/joints/{kind}/{name}", False]["Scalars:scalars"]
            np.testing.assert_array_equal(numbers(curve), np.array(values)[:, k])
