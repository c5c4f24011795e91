"""What a scene looks like, over HTTP: every body, where it is, in its colours; meshes by digest."""

import hashlib
import io

import numpy as np
import trimesh

from tests.service.conftest import BLOCK_SCENE

# A roof of two slopes: not its own convex hull once a wall is taken away; with a colour of its own.
_OBJ = """mtllib roof.mtl
o roof
v 0 0 0
v 0.2 0 0
v 0.2 0.1 0
v 0 0.1 0
v 0.1 0.05 0.1
usemtl red
f 1 2 5
f 2 3 5
f 3 4 5
f 4 1 5
"""
_MTL = "newmtl red\nKd 0.9 0.1 0.2\n"
_SHAPES = {"box", "sphere", "cylinder", "capsule", "ellipsoid", "half_space", "mesh"}


def geometry(client, scene, **headers):
    answer = client.get(f"/v1/scenes/{scene}/geometry", headers=headers)
    assert answer.status_code == 200, answer.text
    return answer


def matrix(pose):
    w, x, y, z = pose["quaternion"]
    turned = trimesh.transformations.quaternion_matrix([w, x, y, z])
    turned[:3, 3] = pose["position"]
    return turned


def test_every_body_of_a_scene_has_a_shape_and_a_colour(client, scene):
    shown = client.get(f"/v1/scenes/{scene}").json()
    bodies = {body["name"]: body for body in geometry(client, scene).json()["bodies"]}
    # these three have no shape
    assert set(shown["bodies"]) - set(bodies) == {"world", "arm::tcp", "arm::tool0"}
    assert set(bodies) <= set(shown["bodies"])
    block = bodies["block"]
    assert block["shapes"][0]["box"] == [0.1, 0.1, 0.1]
    np.testing.assert_allclose(matrix(block["pose"]), matrix_at(0.6, 0, 0.05), atol=1e-12)
    for body in bodies.values():
        for shape in body["shapes"]:
            assert len([name for name in _SHAPES if shape[name] is not None]) == 1
            assert all(0 <= part <= 1 for part in shape["color"])


def matrix_at(*position):
    found = np.eye(4)
    found[:3, 3] = position
    return found


def test_what_moves_has_no_pose_and_fk_knows_its_frame(client, scene):
    moving = [b["name"] for b in geometry(client, scene).json()["bodies"] if b["pose"] is None]
    assert any(name.endswith("wrist_3_link") for name in moving)
    request = {"group": "arm", "configurations": [[0.0] * 6, [0.5] * 6], "frames": moving}
    answer = client.post(f"/v1/scenes/{scene}/fk", json=request)
    assert answer.status_code == 200, answer.text
    first, second = answer.json()["results"]
    assert all(first[name] != second[name] for name in moving)


def test_a_known_revision_is_not_sent_again(client, scene):
    etag = geometry(client, scene).headers["etag"]
    again = client.get(f"/v1/scenes/{scene}/geometry", headers={"If-None-Match": etag})
    assert (again.status_code, again.content) == (304, b"")


def test_a_mesh_comes_with_its_triangles_its_scale_and_its_colour(client, tmp_path):
    (tmp_path / "roof.obj").write_text(_OBJ)
    (tmp_path / "roof.mtl").write_text(_MTL)
    roof = {"uri": str(tmp_path / "roof.obj"), "scale": [1.0, 2.0, 3.0]}
    seen = {"name": "roof", "shape": {"mesh": roof}, "pose": {"position": [0, 0.6, 0.5]}}
    posted = client.post("/v1/scenes", json={**BLOCK_SCENE, "objects": [seen], "frames": []})
    assert posted.status_code == 201, posted.text
    scene = posted.json()["id"]
    bodies = {body["name"]: body for body in geometry(client, scene).json()["bodies"]}
    digest = bodies["roof"]["shapes"][0]["mesh"]["sha256"]

    answer = client.get(f"/v1/scenes/{scene}/geometry/{digest}.glb")
    assert answer.headers["content-type"] == "model/gltf-binary"
    assert "immutable" in answer.headers["cache-control"]
    assert hashlib.sha256(answer.content).hexdigest() == digest
    loaded = trimesh.load_scene(io.BytesIO(answer.content), file_type="glb")
    mesh = loaded.to_mesh()
    assert len(mesh.faces) == 4
    np.testing.assert_allclose(mesh.bounds, [[0, 0, 0], [0.2, 0.2, 0.3]], atol=1e-6)
    (part,) = loaded.geometry.values()
    np.testing.assert_allclose(
        np.array(part.visual.material.main_color)[:3] / 255, [0.9, 0.1, 0.2], atol=0.01
    )


def test_a_mesh_of_another_scene_is_not_found(client, scene):
    answer = client.get(f"/v1/scenes/{scene}/geometry/{'0' * 64}.glb")
    assert (answer.status_code, answer.json()["code"]) == (404, "not_found")
