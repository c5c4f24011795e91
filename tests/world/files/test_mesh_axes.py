"""A mesh is the same thing in every format: metres, z up."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from pydrake.geometry import Mesh

import planning
from planning.errors import ModelInvalid
from planning.world.world import World

# A corner apart from the rest, so that no turn and no mirror image leaves it as it is.
CORNERS = np.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.3]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
Y_UP = CORNERS @ np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])  # (x, z, -y)
X_UP = CORNERS @ np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]])  # (z, -x, -y)


def write(file: Path, corners: np.ndarray, asset: str = "") -> Path:
    mesh = trimesh.Trimesh(corners, FACES, process=False)
    if file.suffix == ".gltf":
        files: Any = trimesh.Scene(mesh).export(file_type="gltf")
        for name, content in files.items():
            (file if name == "model.gltf" else file.with_name(name)).write_bytes(content)
        return file
    mesh.export(file)
    if asset:
        text = re.sub(
            r"<asset>.*?</asset>", f"<asset>{asset}</asset>", file.read_text(), flags=re.DOTALL
        )
        file.write_text(text)
    return file


@pytest.fixture
def corners_of(tmp_path: Path) -> Callable[[Path], np.ndarray]:
    def load(mesh: Path) -> np.ndarray:
        """Return the corners of the collision shape that Drake has of a mesh, sorted."""
        urdf = tmp_path / "m.urdf"
        urdf.write_text(
            '<robot name="r"><link name="base"/><link name="a"><collision><geometry>'
            f'<mesh filename="{mesh.name}"/></geometry></collision></link>'
            '<joint name="j" type="continuous"><parent link="base"/><child link="a"/></joint>'
            "</robot>"
        )
        return hull_corners(load_model(urdf))

    return load


def load_model(file: Path) -> World:
    robot = {"name": "r", "model": str(file)}
    return planning.load_world(planning.parse_scene({"name": "t", "robots": [robot]}))


def hull_corners(world: World) -> np.ndarray:
    plant, inspector = world.drake.plant, world.drake.scene_graph.model_inspector()
    (geometry,) = plant.GetCollisionGeometriesForBody(plant.get_body(world.drake.bodies["r::a"]))
    shape = inspector.GetShape(geometry)
    assert isinstance(shape, Mesh)
    hull = shape.GetConvexHull()
    corners = np.array([hull.vertex(i) for i in range(hull.num_vertices())])
    return np.array(sorted(corners.round(6).tolist()))


EXPECTED = np.array(sorted(CORNERS.tolist()))


@pytest.mark.parametrize(
    ("name", "corners", "asset"),
    [
        ("m.obj", CORNERS, ""),
        ("m.stl", CORNERS, ""),
        ("m.ply", CORNERS, ""),
        ("m.glb", Y_UP, ""),
        ("m.gltf", Y_UP, ""),
        ("z.dae", CORNERS, '<unit meter="1"/><up_axis>Z_UP</up_axis>'),
        ("y.dae", Y_UP, "<up_axis>Y_UP</up_axis>"),
        ("default.dae", Y_UP, "<created/>"),
        ("x.dae", X_UP, "<up_axis>X_UP</up_axis>"),
        ("mm.dae", CORNERS * 1000, '<unit name="mm" meter="0.001"/><up_axis>Z_UP</up_axis>'),
        ("inch.dae", Y_UP / 0.0254, '<unit meter="0.0254"/><up_axis>Y_UP</up_axis>'),
    ],
)
def test_a_mesh_is_the_same_in_every_format(
    corners_of: Callable[..., np.ndarray],
    tmp_path: Path,
    name: str,
    corners: np.ndarray,
    asset: str,
) -> None:
    found = corners_of(write(tmp_path / name, corners, asset))
    np.testing.assert_allclose(found, EXPECTED, atol=2e-6)


@pytest.mark.parametrize(
    "asset",
    ['<unit meter="0"/>', '<unit meter="-1"/>', '<unit meter="nan"/>', "<up_axis>W_UP</up_axis>"],
)
def test_a_unit_or_axis_that_is_none_is_refused(
    corners_of: Callable[..., np.ndarray], tmp_path: Path, asset: str
) -> None:
    with pytest.raises(ModelInvalid, match=r"m\.dae cannot be read"):
        corners_of(write(tmp_path / "m.dae", CORNERS, asset))


@pytest.mark.parametrize("folder", ["", "parts"])
@pytest.mark.parametrize("given", ["", 'name="q"'])
def test_an_mjcf_with_stl_meshes_loads(tmp_path: Path, folder: str, given: str) -> None:
    (tmp_path / folder).mkdir(exist_ok=True)
    write(tmp_path / folder / "tetra.stl", CORNERS)
    (tmp_path / "m.xml").write_text(
        f'<mujoco model="m"><compiler meshdir="{folder}"/><asset>'
        f'<mesh {given} file="tetra.stl" scale="2 2 2"/></asset><worldbody><body name="a">'
        f'<joint name="j" range="-1 1"/><geom type="mesh" mesh="{"q" if given else "tetra"}"/>'
        "</body></worldbody></mujoco>"
    )
    world = load_model(tmp_path / "m.xml")
    np.testing.assert_allclose(hull_corners(world), 2 * EXPECTED, atol=2e-6)
