"""Worlds are made of the bytes that were there when the scene was accepted, and of nothing else."""

import json
import pickle
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import planning
from planning import AddObject, ModelLibrary, edit_scene, load_world, parse_scene
from planning.domain.scene.kept_files import KeptFiles
from planning.errors import AssetNotFound, ModelInvalid, SceneInvalid
from planning.world.files.file_store import FileStore
from planning.world.fingerprint import collision_fingerprint
from tests.conftest import whole_world

CARD = """
name: {name}
file: {file}
base: base
default_group: arm
groups: {{arm: {{joints: [j]}}}}
"""
TRIANGLES = [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)]
TRIANGLES += [(2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]


def corners(half):
    return [(x, y, z) for x in (-half, half) for y in (-half, half) for z in (-half, half)]


def obj(half, materials=""):
    rows = [f"v {x} {y} {z}" for x, y, z in corners(half)]
    rows += ["f " + " ".join(str(i + 1) for i in triangle) for triangle in TRIANGLES]
    return "\n".join([materials, *rows])


def stl(half):
    points = np.array(corners(half))
    rows = ["solid s"]
    for triangle in TRIANGLES:
        rows += ["facet normal 0 0 0", "outer loop"]
        rows += [f"vertex {x} {y} {z}" for x, y, z in points[list(triangle)]]
        rows += ["endloop", "endfacet"]
    return "\n".join([*rows, "endsolid s"])


def gltf(folder, half):
    points = np.array(corners(half), dtype="<f4")
    rows = np.array(TRIANGLES, dtype="<u2")
    (folder / "box.bin").write_bytes(points.tobytes() + rows.tobytes())
    lower, upper = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    size = {"POSITION": 0}
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": size, "indices": 1}]}],
        "buffers": [{"uri": "box.bin", "byteLength": points.nbytes + rows.nbytes}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": points.nbytes},
            {"buffer": 0, "byteOffset": points.nbytes, "byteLength": rows.nbytes},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3"}
            | {"min": lower, "max": upper},
            {"bufferView": 1, "componentType": 5123, "count": rows.size, "type": "SCALAR"},
        ],
    }
    (folder / "box.gltf").write_text(json.dumps(document))


def urdf(mesh, *, name="m", upper=2.0):
    return f"""<robot name="{name}"><link name="base"/><link name="a"><collision><geometry>
    <mesh filename="{mesh}"/></geometry></collision></link>
    <joint name="j" type="prismatic"><parent link="base"/><child link="a"/><axis xyz="1 0 0"/>
    <limit lower="-2" upper="{upper}" velocity="1" effort="1"/></joint></robot>"""


def rich_robot(folder):
    """A robot of a package whose description, card, SRDF, mesh, material and texture are files."""
    package = folder / "robots"
    (package / "urdf").mkdir(parents=True)
    (package / "meshes").mkdir()
    (package / "package.xml").write_text("<package><name>of_robots</name></package>")
    (package / "urdf/m.urdf").write_text(urdf("package://of_robots/meshes/box.obj"))
    (package / "urdf/m.srdf").write_text('<robot name="m"><group name="g"/></robot>')
    (package / "urdf/robot.yaml").write_text(CARD.format(name="m", file="m.urdf"))
    (package / "meshes/box.obj").write_text(obj(0.1, "mtllib paint.mtl\nusemtl red"))
    (package / "meshes/paint.mtl").write_text("newmtl red\nKd 1 0 0\nmap_Kd red.png\n")
    (package / "meshes/red.png").write_bytes(bytes([137, 80, 78, 71]))
    return package / "urdf/m.urdf"


def mujoco(folder):
    """A robot in two files and a mesh."""
    (folder / "parts").mkdir(parents=True)
    (folder / "parts/box.obj").write_text(obj(0.1))
    (folder / "joint.xml").write_text(
        """<mujoco><worldbody><body name="tip" pos="0 0 1">
        <joint name="j" type="hinge" axis="0 0 1" range="-60 60"/>
        <geom type="mesh" mesh="b"/></body></worldbody></mujoco>"""
    )
    (folder / "r.xml").write_text(
        """<mujoco model="r"><compiler meshdir="parts"/><include file="joint.xml"/>
        <asset><mesh name="b" file="box.obj"/></asset></mujoco>"""
    )
    return folder / "r.xml"


def with_buffer(folder):
    """A robot whose mesh has its numbers in a file of its own."""
    folder.mkdir(parents=True)
    gltf(folder, 0.1)
    (folder / "r.urdf").write_text(urdf("box.gltf"))
    return folder / "r.urdf"


def with_stl(folder):
    """A robot whose mesh is made into another before Drake reads it; named by an absolute path."""
    folder.mkdir(parents=True)
    (folder / "box.stl").write_text(stl(0.1))
    (folder / "r.urdf").write_text(urdf(folder / "box.stl"))
    return folder / "r.urdf"


ROBOTS = {robot.__name__: robot for robot in (rich_robot, mujoco, with_buffer, with_stl)}
NUM_FILES = {"rich_robot": 7, "mujoco": 3, "with_buffer": 3, "with_stl": 2}


@pytest.fixture
def library(tmp_path):
    return ModelLibrary.bundled(copies=tmp_path / "copies")


def scene_of(*files, **more):
    robots = [
        {"name": f"r{i}", "model": str(file), "base": {"position": [0, i, 0]}}
        for i, file in enumerate(files)
    ]
    return parse_scene({"robots": robots, **more})


def radii(world):
    """How far each robot's body reaches from its own origin."""
    inspector = whole_world(world).drake.scene_graph.model_inspector()
    shapes = [inspector.GetShape(geometry) for geometry in inspector.GetAllGeometryIds()]
    hulls = [s.GetConvexHull() for s in shapes if hasattr(s, "GetConvexHull")]
    return [max(np.linalg.norm(h.vertex(i)) for i in range(h.num_vertices())) for h in hulls]


@pytest.mark.parametrize("name", ROBOTS)
def test_the_digest_covers_every_byte_of_every_file(name, tmp_path, library):
    file = ROBOTS[name](tmp_path / "here")
    first = load_world(scene_of(file), library)
    sources = [path for path in (tmp_path / "here").rglob("*") if path.is_file()]
    assert len(sources) == len(first.scene.files["r0"].sha256) == NUM_FILES[name]
    seen = {first.digest}
    for source in sources:
        content = source.read_bytes()
        # What follows the last element of a document is white space to every one of the parsers.
        source.write_bytes(content + (b"0" if source.suffix in (".bin", ".png") else b"\n"))
        seen.add(load_world(scene_of(file), library).digest)
        source.write_bytes(content)
    assert len(seen) == 1 + len(sources)
    assert load_world(scene_of(file), library).digest == first.digest


@pytest.mark.parametrize("name", ROBOTS)
def test_an_accepted_scene_outlives_its_files(name, tmp_path, library):
    file = ROBOTS[name](tmp_path / "here")
    accepted = load_world(scene_of(file), library)
    for source in (tmp_path / "here").rglob("*"):
        if source.suffix in (".obj", ".stl"):
            source.write_text({".obj": obj, ".stl": stl}[source.suffix](0.4))
    if (tmp_path / "here/box.bin").exists():
        gltf(tmp_path / "here", 0.4)
    changed = load_world(scene_of(file), library)
    shutil.rmtree(tmp_path / "here")
    again = load_world(pickle.loads(pickle.dumps(accepted.scene)), library)
    assert again.digest == accepted.digest != changed.digest
    assert radii(again) == radii(accepted) == pytest.approx([0.1 * 3**0.5] * len(radii(again)))
    assert radii(changed) == pytest.approx([0.4 * 3**0.5] * len(radii(again)))
    with pytest.raises(AssetNotFound, match="there is no file"):
        load_world(scene_of(file), library)


@pytest.mark.parametrize("name", ["rich_robot", "mujoco", "with_buffer"])
def test_what_is_named_relatively_may_lie_anywhere(name, tmp_path, library):
    found = [
        load_world(scene_of(ROBOTS[name](tmp_path / folder / "robots")), library).scene
        for folder in ("a", "b/c")
    ]
    assert found[0].files["r0"].content == found[1].files["r0"].content


def test_limits_are_those_of_the_file_now(tmp_path, library):
    folder = tmp_path / "here"
    file = rich_robot(folder)
    before = load_world(scene_of(file), library)
    file.write_text(urdf("package://of_robots/meshes/box.obj", upper=0.5))
    after = load_world(scene_of(file), library)
    again = load_world(before.scene, library)
    uppers = [float(w.limits(w.group("r0")).upper[0]) for w in (before, after, again)]
    assert uppers == [2.0, 0.5, 2.0]
    assert before.digest == again.digest != after.digest


def mesh_object(name, uri, x=1.0):
    pose = {"position": [x, 0, 0]}
    return {"name": name, "shape": {"mesh": {"uri": str(uri)}}, "pose": pose}


def test_an_object_keeps_its_mesh_and_one_that_is_added_later_has_its_own(tmp_path, library):
    mesh, file = tmp_path / "o.obj", rich_robot(tmp_path / "here")
    mesh.write_text(obj(0.1))
    first = load_world(scene_of(file, objects=[mesh_object("old", mesh)]), library)
    mesh.write_text(obj(0.3))
    added = parse_scene({
        "robots": [{"name": "x", "model": "ur5e"}],
        "objects": [mesh_object("new", mesh, 2.0)],
    }).objects[0]
    both = load_world(edit_scene(first.scene, [AddObject(added)], library), library)
    assert both.scene.files["old"] == first.scene.files["old"] != both.scene.files["new"]
    assert sorted(radii(both)) == pytest.approx([0.1 * 3**0.5] * 3 + [0.3 * 3**0.5] * 2)
    anew = [planning.RemoveObject("old"), AddObject(replace(added, name="old"))]
    replaced = load_world(edit_scene(first.scene, anew, library), library)
    assert replaced.scene.files["old"].sha256 == both.scene.files["new"].sha256


def test_roadmaps_are_known_by_what_the_files_hold(tmp_path, library):
    file = rich_robot(tmp_path / "here")
    mesh = file.parent.parent / "meshes/box.obj"

    def seen():
        world = load_world(scene_of(file), library)
        return collision_fingerprint(world, world.group("r0"))

    before = seen()
    mesh.write_text(mesh.read_text() + "\n# the same box")
    assert seen() == before
    mesh.write_text(obj(0.4))
    assert seen() != before


def test_files_of_another_model_are_not_taken(tmp_path, library):
    one, two = rich_robot(tmp_path / "one"), with_stl(tmp_path / "two")
    first = load_world(scene_of(one), library).scene
    robot = replace(first.robots[0], model=str(two))
    changed = load_world(replace(first, robots=(robot,)), library).scene
    assert changed.files["r0"].main == "r.urdf"


def test_robots_of_packages_of_one_name_keep_apart(tmp_path, library):
    one, two = rich_robot(tmp_path / "one"), rich_robot(tmp_path / "two")
    (two.parent.parent / "meshes/box.obj").write_text(obj(0.4))
    world = load_world(scene_of(one, two), library)
    assert sorted(radii(world)) == pytest.approx([0.1 * 3**0.5, 0.4 * 3**0.5])


def test_a_damaged_copy_is_made_anew_and_a_lost_one_is_missed(tmp_path, library):
    scene = load_world(scene_of(rich_robot(tmp_path / "here")), library).scene
    kept = scene.files["r0"]
    store = FileStore(tmp_path / "copies")
    mesh = store.folder_of(kept.sha256) / "robots/meshes/box.obj"
    mesh.write_text(obj(0.4))
    (mesh.parent / "more.obj").write_text(obj(0.4))
    again = load_world(scene, library)
    assert radii(again) == pytest.approx([0.1 * 3**0.5])
    assert not (mesh.parent / "more.obj").exists()
    shutil.rmtree(tmp_path / "copies/folders")
    assert load_world(scene, library).digest == again.digest
    shutil.rmtree(tmp_path / "copies/folders")
    original = tmp_path / "copies/bytes" / kept.sha256["robots/meshes/box.obj"]
    original.write_text(obj(0.4))
    with pytest.raises(AssetNotFound, match="damaged"):
        load_world(scene, library)
    original.unlink()
    with pytest.raises(AssetNotFound, match="is missing"):
        load_world(scene, library)


def test_faults_name_the_files_and_not_their_copies(tmp_path, library):
    file = rich_robot(tmp_path / "here")
    file.write_text(file.read_text().replace("box.obj", "bax.obj"))
    with pytest.raises(AssetNotFound, match=r"bax\.obj") as caught:
        load_world(scene_of(file), library)
    assert caught.value.detail.startswith(f"{file.name} names")
    assert "copies" not in caught.value.detail
    file.write_text("<robot")
    with pytest.raises(ModelInvalid) as broken:
        load_world(scene_of(file), library)
    assert broken.value.evidence["file"] == str(file)
    with pytest.raises(SceneInvalid, match=r"objects\.0\.shape: .*there is no file"):
        load_world(scene_of("ur5e", objects=[mesh_object("o", tmp_path / "none.obj")]), library)


def test_what_cannot_be_kept_is_refused(tmp_path, library):
    file = with_stl(tmp_path / "here")
    # The same path to a parser, but not to the one who makes it relative.
    file.write_text(file.read_text().replace('filename="/', 'filename="&#47;'))
    with pytest.raises(ModelInvalid, match="cannot be copied"):
        load_world(scene_of(file), library)


def test_meshes_are_not_named_by_path_where_robots_are_not(tmp_path):
    mesh = tmp_path / "o.obj"
    mesh.write_text(obj(0.1))
    strict = ModelLibrary.bundled(allow_paths=False, copies=tmp_path / "copies")
    with pytest.raises(AssetNotFound, match="by path"):
        load_world(scene_of("ur5e", objects=[mesh_object("o", mesh)]), strict)


PLAIN = {"named": "r", "main": "a/r.urdf", "card": "", "sha256": {"a/r.urdf": "0" * 64}}


def test_files_are_told_as_json_and_read_again():
    assert KeptFiles.from_json(json.loads(json.dumps(PLAIN))).as_json == PLAIN


@pytest.mark.parametrize(
    "fault",
    [
        {"sha256": {"../r.urdf": "0" * 64}, "main": "../r.urdf"},
        {"sha256": {"/r.urdf": "0" * 64}, "main": "/r.urdf"},
        {"sha256": {"a/r.urdf": "../../x"}},
        {"main": "b.urdf"},
        {"card": "robot.yaml"},
    ],
)
def test_files_outside_of_their_folder_are_refused(fault):
    with pytest.raises(SceneInvalid, match="files of 'r'"):
        KeptFiles.from_json(PLAIN | fault)


def test_bundled_scenes_keep_their_robots(library):
    file = planning.bundled_folder("scenes") / "ur5e_pickup.scene.yaml"
    world = load_world(planning.read_scene(file), library)
    assert sorted(world.scene.files["arm"].sha256) == ["robot.yaml", "ur5e.urdf"]
    assert set(world.scene.files) == {"arm"}


def test_paths_that_step_back_are_followed(tmp_path, library):
    (tmp_path / "urdf/empty").mkdir(parents=True)
    (tmp_path / "box.obj").write_text(obj(0.1))
    file = Path(tmp_path / "urdf/r.urdf")
    file.write_text(urdf("empty/../../box.obj"))
    world = load_world(scene_of(file), library)
    assert set(world.scene.files["r0"].sha256) == {"urdf/r.urdf", "box.obj"}
