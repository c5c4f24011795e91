"""Hostile files that name others, that are no files, or that are not as long as they say.

Read by test_files.py, with the columns of files.py; what is called is called with the path that it
is to make.
"""

import os
import struct

from tests.service.hostile.files import INVALID, gltf, include, mjcf, robot, sdf, urdf

PASSWORDS = "../" * 30 + "etc/passwd"
MISSING = "asset_not_found"
HEAD = b"\0" * 80


def by_robot(name, content, code, word):
    """A mesh that a robot names: those of robots are converted, those of scenes are not."""
    return {name: content, "r.urdf": urdf(f'<mesh filename="{name}"/>')}, code, word


def stl(count, *triangles):
    rows = [struct.pack("<12fH", 0, 0, 1, *corners, 0) for corners in triangles]
    return HEAD + struct.pack("<I", count) + b"".join(rows)


def pipe(path):
    """A pipe, which nothing is written to: who opens it waits."""
    os.mkfifo(path)


def circle(path):
    """A link to itself."""
    path.symlink_to(path)


def device(path):
    """A link to what has no end."""
    path.symlink_to("/dev/zero")


SOLID = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n"
PICTURE = (
    '<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>'
    '<up_axis>Z_UP</up_axis></asset><library_images><image id="i"><init_from>http://x.example/a'
    "</init_from></image></library_images></COLLADA>"
)
FEW = "found 1 vertices"
ROBOTS = {
    "pipe": ({"r.urdf": pipe}, MISSING, "there is no file"),
    "link to itself": ({"r.urdf": circle}, MISSING, "there is no file"),
    "link to a device": ({"r.urdf": device}, MISSING, "there is no file"),
    "mesh of a file above": robot(urdf(f'<mesh filename="{PASSWORDS}"/>'), INVALID, "format"),
    "mesh of the disk": robot(urdf('<mesh filename="file:///etc/passwd"/>'), INVALID, "format"),
    "mesh of a device": robot(urdf('<mesh filename="/dev/zero"/>'), INVALID, "cannot be copied"),
    "mesh above a package": robot(
        urdf(f'<mesh filename="package://{PASSWORDS}"/>'), INVALID, "passwd"
    ),
    "mesh of a pipe": by_robot("m.stl", pipe, MISSING, "m.stl"),
    "SDF of the web": ({"r.sdf": sdf(include("https://x.example/a"))}, INVALID, "does not exist"),
    "SDF of the disk": ({"r.sdf": sdf(include("/etc/passwd"))}, INVALID, "includes"),
    "SDF of a file above": ({"r.sdf": sdf(include(PASSWORDS))}, INVALID, "is no description"),
    "SDF of a text": (
        {"p.sdf": "hello", "r.sdf": sdf(include("p.sdf"))}, INVALID, "is no description"
    ),
    "SDF above a model": (
        {"r.sdf": sdf(include("model://../../etc"))}, INVALID, "does not exist"
    ),
    "MJCF of the disk": ({"r.xml": mjcf('<include file="/etc/passwd"/>')}, INVALID, "not XML"),
    "encoding of UTF-7": robot(
        '<?xml version="1.0" encoding="utf-7"?>' + urdf(), INVALID, "not XML"
    ),
    "xacro": (
        {"r.urdf.xacro": "<robot>${__import__('os').abort()}</robot>"}, MISSING, "expand it first"
    ),
    "joints in a circle": (
        {"r.urdf": urdf(more='<joint name="k" type="fixed"><parent link="a"/><child link="base"/>'
                             "</joint>")},
        INVALID, "r.urdf",
    ),
    "card of aliases": robot(
        urdf(), INVALID, "aliases", **{"robot.yaml": "a: &a [x]\nb: [*a, *a]"}
    ),
    "card that is deep": robot(urdf(), INVALID, "nested", **{"robot.yaml": "[" * 5000}),
    "STL of many triangles": by_robot("m.stl", stl(4_000_000_000), INVALID, FEW),
    "STL of nothing": by_robot("m.stl", stl(0), INVALID, FEW),
    "STL of one point": by_robot("m.stl", stl(1, [0] * 9), INVALID, FEW),
    "STL that ends early": by_robot("m.stl", "solid a\nfacet", INVALID, FEW),
    "OFF of many points": by_robot(
        "m.off", "OFF\n4000000000 1 0\n0 0 0\n3 0 1 2\n", INVALID, "4000000000"
    ),
    "GLB that ends early": by_robot(
        "m.glb", struct.pack("<4sIIII", b"glTF", 2, 20, 2**32 - 1, 0x4E4F534A), INVALID, "m.glb"
    ),
    "GLB of four letters": by_robot("m.glb", b"glTF", INVALID, "m.glb"),
    "zipped COLLADA": by_robot("m.zae", b"PK\3\4" + b"\0" * 99, INVALID, "unsupported format"),
    "ZIP that says it is COLLADA": by_robot("m.dae", b"PK\3\4" + b"\0" * 99, INVALID, "m.dae"),
    "COLLADA with a picture of the web": by_robot("m.dae", PICTURE, INVALID, "m.dae"),
}  # fmt: skip
SHAPE = "objects.0.shape"
MESHES = {
    "OBJ of a pipe": ({"m.obj": pipe}, "scene_invalid", "there is no file"),
    "OBJ of a device": ({"m.obj": device}, "scene_invalid", "there is no file"),
    "OBJ of a link to itself": ({"m.obj": circle}, "scene_invalid", "there is no file"),
    "OBJ of one point": ({"m.obj": "v 0 0 0\n" * 4 + "f 1 2 3\n"}, "scene_invalid", SHAPE),
    "OBJ of one line": (
        {"m.obj": "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"}, "scene_invalid", "co-linear"
    ),
    "OBJ beyond all numbers": ({"m.obj": SOLID.replace("1 ", "1e300 ", 1)}, "scene_invalid", SHAPE),
    "OBJ of vertex 0": ({"m.obj": SOLID + "f 0 1 2\n"}, "scene_invalid", SHAPE),
    "OBJ of a vertex before the first": ({"m.obj": SOLID + "f -1 -2 -9\n"}, "scene_invalid", SHAPE),
    "OBJ in gzip": ({"m.obj": b"\x1f\x8b\x08" + b"\0" * 99}, "scene_invalid", "0 vertices"),
    "buffer of the disk": (
        gltf("buffers", 0, "uri", to="file:///etc/passwd"), INVALID, "leaves the folder"
    ),
    "glTF that is deep": ({"m.gltf": "[" * 100_000}, INVALID, "not JSON"),
    "glTF with a picture of the web": (
        gltf("images", to=[{"uri": "http://x.example/a.png"}]), None, ""
    ),
}  # fmt: skip
OUTSIDE = {
    **{f"robot: {k}": v for k, v in ROBOTS.items()},
    **{f"mesh: {k}": v for k, v in MESHES.items()},
}
