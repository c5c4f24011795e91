"""Attack on what a description says beyond plain URDF: shapes, followers, units, axes and formats.

Each attack writes a robot whose motion truly collides, by the specification of its format. It must
be refused, or not proven.
"""

import base64
import time
from pathlib import Path
from typing import Any

import numpy as np

import planning
from planning import scene_summary
from planning.errors import WayproofError
from tests.adversary.cases import PATIENCE, Document, Outcome
from tests.adversary.draws import meshes

_WALL = {"name": "wall", "shape": {"box": [2.0, 2.0, 2.0]}}


def _sdf(geometry: str, more: str = "") -> str:
    limit = "<limit><lower>-1</lower><upper>1</upper></limit>"
    return (
        '<sdf version="1.9"><model name="m"><link name="base"/><joint name="w" type="fixed">'
        '<parent>world</parent><child>base</child></joint><link name="a"><collision name="c">'
        f'<geometry>{geometry}</geometry></collision></link><joint name="j" type="revolute">'
        f"<parent>base</parent><child>a</child><axis><xyz>0 0 1</xyz>{limit}</axis></joint>{more}"
        "</model></sdf>"
    )


def _mjcf(geom: str, more: str = "", bodies: str = "") -> str:
    return (
        f'<mujoco model="m"><compiler angle="radian"/>{more}<worldbody><body name="a"><joint '
        f'name="j" type="hinge" axis="0 0 1" range="-1 1" limited="true"/>{geom}</body>{bodies}'
        "</worldbody></mujoco>"
    )


def _shape(rng: np.random.Generator, name: str) -> Document:
    size = float(rng.uniform(0.3, 1.0))
    texts = {
        "polyline.sdf": _sdf(
            f"<polyline><point>0 0</point><point>{size} 0</point><point>0 {size}</point>"
            f"<height>{size}</height></polyline>"
        ),
        "heightmap.sdf": _sdf(f"<heightmap><uri>x.png</uri><size>{size} 1 1</size></heightmap>"),
        "cone.sdf": _sdf(f"<cone><radius>{size}</radius><length>1</length></cone>"),
        "plane.sdf": _sdf("<plane><normal>0 0 1</normal><size>1 1</size></plane>"),
        "hfield.xml": _mjcf('<geom type="hfield" hfield="h"/>'),
        "fromto.xml": _mjcf(f'<geom type="box" fromto="0 0 0 {size} 0 0" size="0.1"/>'),
        "missing.xml": _mjcf('<geom type="mesh" mesh="q"/>'),
    }
    return {"files": {name: texts[name]}, "around": [_WALL], "q": [[-0.5], [0.5]]}


def _reference(rng: np.random.Generator, _: str) -> Document:
    """SDF: follower = multiplier (leader - reference) + offset."""
    multiplier, offset, reference = 2.0, float(rng.uniform(-0.5, 0.5)), float(rng.uniform(0.3, 0.9))
    box = "<geometry><box><size>0.9 0.02 0.02</size></box></geometry>"
    arm = f'<link name="b"><collision name="c"><pose>0.55 0 0 0 0 0</pose>{box}</collision></link>'
    numbers = f"<multiplier>{multiplier}</multiplier><offset>{offset}</offset>"
    follow = f'<mimic joint="j">{numbers}<reference>{reference}</reference></mimic>'
    limit = "<limit><lower>-3</lower><upper>3</upper></limit>"
    joint = (
        '<joint name="k" type="revolute"><parent>base</parent><child>b</child>'
        f"<axis><xyz>0 0 1</xyz>{limit}{follow}</axis></joint>"
    )
    angle = multiplier * (0.0 - reference) + offset
    text = _sdf("<box><size>0.01 0.01 0.01</size></box>", arm + joint)
    return {"files": {"ref.sdf": text}, "around": [_post(angle)], "q": [[0.0], [0.1]]}


def _post(angle: float, height: float = 0.0) -> Document:
    place = [0.9 * float(np.cos(angle)), 0.9 * float(np.sin(angle)), height]
    return {"name": "post", "shape": {"box": [0.02, 0.02, 0.1]}, "pose": {"position": place}}


def _equality(rng: np.random.Generator, _: str) -> Document:
    """MJCF: joint1 - joint1_0 = c0 + c1 (joint2 - joint2_0)."""
    offset, factor = float(rng.uniform(0.5, 1.0)), float(rng.uniform(0.5, 1.5))
    hinge = '<joint name="k" type="hinge" axis="0 0 1" range="-3 3" limited="true"/>'
    box = '<geom type="box" pos="0.55 0 0" size="0.45 0.01 0.01"/>'
    arm = f'<body name="b">{hinge}{box}</body>'
    tie = f'<equality><joint joint1="k" joint2="j" polycoef="{offset} {factor} 0 0 0"/></equality>'
    text = _mjcf('<geom type="box" size="0.005 0.005 0.005"/>', tie, arm)
    return {
        "files": {"tie.xml": text},
        "around": [_post(offset)],
        "q": [[0.0], [0.1]],
        "only": "r::j",
    }


def _coded(content: bytes) -> Document:
    return {"base64": base64.b64encode(content).decode()}


def _arm(mesh: str) -> str:
    """Return a URDF of a link of one mesh that turns about z."""
    shape = f'<collision><geometry><mesh filename="{mesh}"/></geometry></collision>'
    return (
        f'<robot name="m"><link name="base"/><link name="a">{shape}</link>'
        '<joint name="j" type="revolute"><parent link="base"/><child link="a"/>'
        '<axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>'
    )


def _collada(rng: np.random.Generator, _: str) -> Document:
    """COLLADA: numbers are in a unit of the file's, and y is up unless it says otherwise."""
    unit, up = (
        float(rng.choice([1.0, 0.001, 0.01, 0.0254])),
        str(rng.choice(["X_UP", "Y_UP", "Z_UP"])),
    )
    # High up, so that no other axis makes the same of it.
    corners = meshes.box_corners(np.array([0.2, -0.05, 0.3]), np.array([0.9, 0.05, 0.4]))
    x, y, z = corners.T
    axes = {"X_UP": (z, -x, -y), "Y_UP": (x, z, -y), "Z_UP": (x, y, z)}
    corners = np.stack(axes[up], axis=1)
    files = {"r.urdf": _arm("m.dae"), "m.dae": _coded(meshes.dae(corners / unit, unit, up))}
    return {"files": files, "around": [_post(0.0, 0.35)], "q": [[-0.3], [0.3]]}


def _twins(rng: np.random.Generator, _: str) -> Document:
    """The same mesh as .glb and as .gltf: the same distances."""
    low = rng.uniform(-0.3, -0.05, size=3)
    corners = meshes.box_corners(low, low + rng.uniform(0.1, 0.8, size=3))
    files: Document = {"r.urdf": _arm("m.glb"), "s.urdf": _arm("m.gltf")}
    files |= {"m.glb": _coded(meshes.glb(corners)), "m.gltf": _coded(meshes.gltf(corners))}
    place = (2 * rng.normal(size=3)).tolist()
    probe = {"name": "probe", "shape": {"sphere": 0.01}, "pose": {"position": place}}
    return {"files": files, "around": [probe], "q": [[0.0], [0.1]], "twin": "s.urdf"}


def _mjcf_mesh(rng: np.random.Generator, _: str) -> Document:
    """MJCF with meshes in STL is read, and collides."""
    size = float(rng.uniform(0.3, 0.9))
    corners = meshes.box_corners(np.array([0, -0.05, -0.05]), np.array([size, 0.05, 0.05]))
    text = _mjcf('<geom type="mesh" mesh="q"/>', '<asset><mesh name="q" file="q.stl"/></asset>')
    files = {"m.xml": text, "q.stl": _coded(meshes.stl(corners))}
    return {"files": files, "around": [_WALL], "q": [[-0.5], [0.5]], "must_load": True}


def _concave(rng: np.random.Generator, _: str) -> Document:
    """A mesh that is not convex counts as its hull, and the scene must say so."""
    corners = meshes.box_corners(-np.ones(3) * 0.3, np.ones(3) * 0.3)
    dent = np.array([0.0, 0.0, float(rng.uniform(-0.2, 0.1))])
    top = [t for t in meshes.TRIANGLES.tolist() if not all(corners[i][2] > 0 for i in t)]
    rim = [(1, 5), (5, 7), (7, 3), (3, 1)]
    triangles = np.array(top + [[a, b, 8] for a, b in rim])
    content = meshes.obj(np.concatenate([corners, dent[None]]), triangles)
    return {
        "files": {"r.urdf": _arm("m.obj"), "m.obj": _coded(content)},
        "around": [],
        "q": [[-0.1], [0.1]],
        "warned": True,
    }


_ATTACKS = {
    **dict.fromkeys(
        (
            "polyline.sdf",
            "heightmap.sdf",
            "cone.sdf",
            "plane.sdf",
            "hfield.xml",
            "fromto.xml",
            "missing.xml",
        ),
        _shape,
    ),
    "reference": _reference,
    "equality": _equality,
    "collada": _collada,
    "twins": _twins,
    "mjcf mesh": _mjcf_mesh,
    "concave": _concave,
}


def draw(rng: np.random.Generator, _: Path) -> Document:
    """Return one of the attacks."""
    name = str(rng.choice(list(_ATTACKS)))
    return {"kind": "formats", "attack": name, **_ATTACKS[name](rng, name)}


def judge(case: Document, folder: Path) -> Outcome:
    """Write the files, and ask."""
    outcome = Outcome()
    for name, content in case["files"].items():
        is_text = isinstance(content, str)
        data = content.encode() if is_text else base64.b64decode(content["base64"])
        (folder / name).write_bytes(data)
    outcome.count("asked")
    try:
        world = _world(case, folder / next(iter(case["files"])))
        _judge(case, folder, world, outcome)
    except WayproofError as fault:
        outcome.count("refused")
        if case.get("must_load"):
            outcome.blame(case["attack"], f"does not load: {fault}", 8)
    return outcome


def _world(case: Document, file: Path) -> Any:
    robot = {"name": "r", "model": str(file)}
    document = {"name": "s", "robots": [robot], "objects": case["around"]}
    return planning.load_world(planning.parse_scene(document))


def _judge(case: Document, folder: Path, world: Any, outcome: Outcome) -> None:
    if case.get("warned"):
        if not scene_summary(world).warnings:
            outcome.blame(case["attack"], "no warning of the hull", 8)
        return
    if "twin" in case:
        other = _world(case, folder / case["twin"])
        gaps = [
            planning.check_configurations(w, "r", np.zeros((1, 1)))[0].nearest.distance
            for w in (world, other)
        ]
        if abs(gaps[0] - gaps[1]) > 1e-6:
            outcome.blame(case["attack"], f"{gaps[0]:.6g} m as .glb, {gaps[1]:.6g} m as .gltf", 8)
        return
    group = world.group("r")
    names = [joint.name for joint in group.joints]
    start, end = (
        np.array([row[0] if name == "r::j" else 0.0 for name in names]) for row in case["q"]
    )
    curve = planning.trajectory_through(
        group.joints, np.array([0.0, 4.0]), np.stack([start, end]), np.zeros((2, len(names)))
    )
    deadline = planning.Deadline.after(PATIENCE, time.process_time)
    certificate, _ = planning.certify_trajectory(world, "r", curve, deadline=deadline)
    if certificate.proven:
        outcome.blame(case["attack"], f"proven with {certificate.min_clearance:.4g} m", 8)
