"""Hostile files of robots and meshes, each with the answer that is right: read by test_files.py.

Columns: files by path, the one that the scene names last; the code (None: it loads); a word of the
detail. Robots are named as robots, meshes as objects.
"""

import base64
import copy
import json
import struct

BOX = '<box size="0.1 0.1 0.1"/>'
LIMIT = '<limit lower="-1" upper="1" velocity="1" effort="1"/>'
INVALID = "model_invalid"


def urdf(shape=BOX, limit=LIMIT, link="a", more=""):
    return (
        f'<robot name="m"><link name="base"/><link name="{link}"><collision><geometry>{shape}'
        f'</geometry></collision></link><joint name="j" type="prismatic"><parent link="base"/>'
        f'<child link="{link}"/><axis xyz="1 0 0"/>{limit}</joint>{more}</robot>'
    )


def limits(lower=-1, upper=1, velocity=1, effort=1):
    return f'<limit lower="{lower}" upper="{upper}" velocity="{velocity}" effort="{effort}"/>'


def card(more):
    return f"name: b\nfile: r.urdf\nbase: base\ndefault_group: g\n{more}\n"


def robot(text, code, word, **more):
    return {**more, "r.urdf": text}, code, word


def sdf(inner):
    link = '<link name="a"/><link name="b"/>'
    joint = '<joint name="j" type="revolute"><parent>b</parent><child>a</child><axis>'
    joint += "<xyz>0 0 1</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis></joint>"
    return f'<sdf version="1.9"><model name="m">{link}{joint}{inner}</model></sdf>'


def include(uri, name="p"):
    return f"<include><uri>{uri}</uri><name>{name}</name></include>"


def twice(uri):
    return include(uri) + include(uri, "q")


BODY = '<body name="a"><joint name="j" type="hinge" range="-1 1"/><geom type="sphere" size=".1"/>'
BODY += '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body>'


def mjcf(inner, body=BODY):
    return f'<mujoco model="m"><worldbody>{body}</worldbody>{inner}</mujoco>'


def doubling(root):
    """A document whose one entity stands for 2^30 letters (known as a billion laughs)."""
    doubled = "".join(f'<!ENTITY e{k + 1} "&e{k};&e{k};">' for k in range(30))
    return f'<!DOCTYPE {root} [<!ENTITY e0 "a">{doubled}]><{root}>&e30;</{root}>'


MESH = '<mesh filename="m.dae"/>'
DOCTYPE = '<?xml version="1.0" encoding="utf-16"?><!DOCTYPE robot [<!ENTITY a "aaaa">]>'
ROBOTS = {
    "document type": robot(f'<!DOCTYPE r [<!ENTITY a "x">]>{urdf()}', INVALID, "entities"),
    "document type in UTF-16": robot((DOCTYPE + urdf()).encode("utf-16"), INVALID, "entities"),
    "entity of a file": robot(
        f'<!DOCTYPE r [<!ENTITY a SYSTEM "/etc/passwd">]>{urdf()}', INVALID, "entities"
    ),
    "SRDF with a document type in UTF-16": robot(
        urdf(), INVALID, "r.srdf: document types",
        **{"r.srdf": (DOCTYPE + "<robot/>").encode("utf-16")},
    ),
    "MJCF with entities that double": ({"r.xml": doubling("mujoco")}, INVALID, "entities"),
    "SDF with entities that double": ({"r.sdf": doubling("sdf")}, INVALID, "entities"),
    "COLLADA with a document type": robot(
        urdf(MESH), INVALID, "entities", **{"m.dae": '<!DOCTYPE a [<!ENTITY a "x">]><COLLADA/>'}
    ),
    "COLLADA with a document type in UTF-16": robot(
        urdf(MESH), INVALID, "entities", **{"m.dae": (DOCTYPE + "<COLLADA/>").encode("utf-16")}
    ),
    "COLLADA with entities that double": robot(
        urdf(MESH), INVALID, "entities", **{"m.dae": doubling("COLLADA")}
    ),
    "COLLADA with a file as an entity": robot(
        urdf(MESH), INVALID, "entities",
        **{"m.dae": '<!DOCTYPE a [<!ENTITY a SYSTEM "/etc/passwd">]><COLLADA>&a;</COLLADA>'},
    ),
    "no XML": robot("robot: {}", INVALID, "not XML"),
    "unknown encoding": robot('<?xml version="1.0" encoding="x"?>' + urdf(), INVALID, "not XML"),
    "nothing": robot("", INVALID, "not XML"),
    "deep": robot("<robot>" + "<a>" * 2000 + "</a>" * 2000 + "</robot>", INVALID, "400 deep"),
    "lower above upper": robot(
        urdf(limit=limits(lower=2)), INVALID, "joint 'j': limit lower 2 is above upper 1"
    ),
    "velocity below zero": robot(
        urdf(limit=limits(velocity=-1)), INVALID, "joint 'j': limit velocity -1 must not be"
    ),
    "effort below zero": robot(urdf(limit=limits(effort=-1)), INVALID, "limit effort -1"),
    "effort of a word": robot(urdf(limit=limits(effort="much")), INVALID, "effort must be a"),
    "velocity of next to nothing": robot(
        urdf(limit=limits(velocity="1e-300")), INVALID,
        "joint 'j': limit velocity 1e-300 must be at least 1e-06, or 0 for none",
    ),
    "SDF with a velocity of next to nothing": (
        {"r.sdf": sdf("").replace("</upper>", "</upper><velocity>1e-9</velocity>")}, INVALID,
        "limit velocity 1e-9 must be at least",
    ),
    "effort of next to nothing": robot(
        urdf(limit=limits(effort="1e-300")), INVALID, "limit effort 1e-300 must be at least 1e-06"
    ),
    "friction beyond all numbers": robot(
        urdf(limit=LIMIT + '<dynamics friction="1e300"/>'), INVALID,
        "joint 'j': friction 1e300 must be at most 1e+06",
    ),
    "limit of NaN": robot(urdf(limit=limits(lower="nan")), INVALID, "limit lower must be a finite"),
    "scope in a link": robot(urdf(link="a::b"), INVALID, "link 'a::b'"),
    "scope in a joint": robot(
        urdf().replace('name="j"', 'name="j::k"'), INVALID, "joint 'j::k': a name must not contain"
    ),
    "joint of no name": robot(
        urdf().replace('name="j"', 'name=""'), INVALID, "joint between 'base' and 'a' has no name"
    ),
    "SRDF with a scope in a group": robot(
        urdf(), INVALID, "r.srdf: group 'g::h': a name must not contain '::'",
        **{"r.srdf": '<robot name="m"><group name="g::h"><joint name="j"/></group></robot>'},
    ),
    "box of no size": robot(urdf('<box size="0 1 1"/>'), INVALID, "box size must be positive"),
    "sphere of infinite size": robot(urdf('<sphere radius="inf"/>'), INVALID, "finite"),
    "box beyond all sizes": robot(
        urdf('<box size="1 1e300 1"/>'), INVALID, "box size must be at most 10000, got '1 1e300 1'"
    ),
    "wide cylinder": robot(
        urdf('<cylinder radius="1e300" length="1"/>'), INVALID, "cylinder radius must be at most"
    ),
    "long cylinder": robot(
        urdf('<cylinder radius="1" length="1e300"/>'), INVALID, "cylinder length must be at most"
    ),
    "wide capsule": robot(
        urdf('<capsule radius="1e300" length="1"/>'), INVALID, "capsule radius must be at most"
    ),
    "SDF with a box beyond all sizes": (
        {"r.sdf": sdf('<link name="c"><collision name="c"><geometry><box><size>1e300 1 1</size>'
                      "</box></geometry></collision></link>")},
        INVALID, "box size must be at most 10000",
    ),
    "MJCF with a box beyond all sizes": (
        {"r.xml": mjcf("", BODY.replace('type="sphere" size=".1"', 'type="box" size="1e300 1 1"'))},
        INVALID, "geom size must be at most 10000, got '1e300 1 1'",
    ),
    "MJCF with a capsule beyond all sizes": (
        {"r.xml": mjcf("", BODY.replace("sphere", 'capsule" fromto="0 0 0 1e300 0 0'))}, INVALID,
        "geom fromto must be at most 10000",
    ),
    "mass below zero": robot(
        urdf(more='<link name="c"><inertial><mass value="-1"/></inertial></link>'), INVALID,
        "mass -1",
    ),
    "mesh of a scheme": robot(
        urdf('<mesh filename="http://x.example/a.obj"/>'), "asset_not_found", "package://"
    ),
    "mesh of nowhere": robot(urdf('<mesh filename="a.obj"/>'), "asset_not_found", "a.obj"),
    "link twice": robot(urdf(more='<link name="a"/>'), INVALID, "'a'"),
    "joint from nowhere": robot(
        urdf(more='<joint name="k" type="fixed"><parent link="x"/><child link="y"/></joint>'),
        INVALID, "'x'",
    ),
    "SDF that includes itself": ({"r.sdf": sdf(include("r.sdf"))}, INVALID, "r.sdf -> r.sdf"),
    "SDFs that include each other": (
        {"q.sdf": sdf(include("r.sdf")), "r.sdf": sdf(include("q.sdf"))}, INVALID,
        "r.sdf -> q.sdf -> r.sdf",
    ),
    "SDF that doubles": (
        {
            **{f"{i}.sdf": sdf(twice(f"{i + 1}.sdf")) for i in range(12)},
            "12.sdf": sdf(""),
            "r.sdf": sdf(include("0.sdf")),
        },
        INVALID, "more than 200",
    ),
    "SDF with a scope": (
        {"r.sdf": sdf("").replace('"a"', '"a::b"').replace("<child>a", "<child>a::b")}, INVALID,
        "link 'a::b'",
    ),
    "SDF with lower above upper": (
        {"r.sdf": sdf("").replace("<lower>-1", "<lower>2")}, INVALID, "joint 'j': limit lower 2"
    ),
    "MJCF that includes itself": (
        {"r.xml": mjcf('<include file="r.xml"/>')}, INVALID, "r.xml -> r.xml"
    ),
    "MJCF that includes itself twice": (
        {"r.xml": mjcf('<include file="r.xml"/><include file="r.xml"/>')}, INVALID, "r.xml -> r.xml"
    ),
    "MJCF that doubles": (
        {
            **{f"{i}.xml": mjcf(f'<include file="{i + 1}.xml"/>' * 2, "") for i in range(12)},
            "12.xml": mjcf("", ""),
            "r.xml": mjcf('<include file="0.xml"/>'),
        },
        INVALID, "more than 100",
    ),
    "MJCF with a range upside down": (
        {"r.xml": mjcf("", BODY.replace("-1 1", "1 -1"))}, INVALID, "joint 'j': limit lower 1"
    ),
    "MJCF with a ball joint": (
        {"r.xml": mjcf("", BODY.replace("hinge", "ball"))}, INVALID,
        "supported types: ['continuous', 'floating', 'planar', 'prismatic', 'revolute']",
    ),
    "MJCF with a scope": ({"r.xml": mjcf("", BODY.replace('"a"', '"a::b"'))}, INVALID, "'a::b'"),
    "card of a list": robot(urdf(), INVALID, "robot.yaml", **{"robot.yaml": "[]"}),
    "card with a joint twice": robot(
        urdf(), INVALID, "groups.g.joints: Value error, 'j' is given twice",
        **{"robot.yaml": card("groups: {g: {joints: [j, j]}}")},
    ),
    "card with a frame twice": robot(
        urdf(), INVALID, "groups.g.tool_frames: Value error, 'a' is given twice",
        **{"robot.yaml": card("groups: {g: {joints: [j], tool_frames: [a, a]}}")},
    ),
    "card with a scope in a group": robot(
        urdf(), INVALID, "a group's name is a word without '::'",
        **{"robot.yaml": card("groups: {g: {joints: [j]}, 'g::h': {joints: [j]}}")},
    ),
    "card with limits upside down": robot(
        urdf(), INVALID, "the lower bound 2 is above the upper bound 1",
        **{"robot.yaml": card("groups: {g: {joints: [j]}}\nlimits: {j: {position: {x: [2, 1]}}}")},
    ),
    "card of a template": robot(urdf(), INVALID, "template", **{"robot.yaml": "{{ card }}"}),
}  # fmt: skip

_SIDES = [(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)]
_FACES = [0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4]
_FACES += [1, 5, 7, 1, 7, 3]
_BYTES = struct.pack("<24f36H", *(c for corner in _SIDES for c in corner), *_FACES)
_DATA = "data:application/octet-stream;base64," + base64.b64encode(_BYTES).decode()
_GLTF = {
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0] * 3,
         "max": [1] * 3},
        {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"},
    ],
    "bufferViews": [
        {"buffer": 0, "byteOffset": 0, "byteLength": 96},
        {"buffer": 0, "byteOffset": 96, "byteLength": 72},
    ],
    "buffers": [{"byteLength": 168, "uri": _DATA}],
}  # fmt: skip


def gltf(*path, to, **more):
    """A cube, with one value another."""
    document = copy.deepcopy(_GLTF)
    part = document
    for step in path[:-1]:
        part = part[step]
    part[path[-1]] = to
    return {**more, "m.gltf": json.dumps(document)}


_V = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
_F = "f 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n"
_VTK = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n"
_VTK += "0 0 0\n1 0 0\n0 1 0\n0 0 1\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n"
MESHES = {
    "sound glTF": (gltf("scene", to=0), None, ""),
    "buffer of a folder above": (gltf("buffers", 0, "uri", to="../"), INVALID, "buffers.0.uri"),
    "buffer of a file above": (gltf("buffers", 0, "uri", to="../x.bin"), INVALID, "leaves"),
    "buffer of the web": (gltf("buffers", 0, "uri", to="http://x/y"), INVALID, "leaves the folder"),
    "buffer that is short": (
        gltf("buffers", 0, "uri", to="x.bin", **{"x.bin": "abc"}), INVALID, "buffers.0 has 3 bytes"
    ),
    "accessor beyond its buffer": (
        gltf("accessors", 0, "count", to=10**6), INVALID, "accessors.0 ends at byte 12000000"
    ),
    "indices beyond their buffer": (
        gltf("accessors", 1, "count", to=3 * 10**6), INVALID, "accessors.1 ends"
    ),
    "stride beyond the buffer": (
        gltf("bufferViews", 0, "byteStride", to=10**5), INVALID, "accessors.0 ends"
    ),
    "view beyond its buffer": (
        gltf("bufferViews", 1, "byteLength", to=10**6), INVALID, "bufferViews.1 ends"
    ),
    "view before its buffer": (gltf("bufferViews", 1, "byteOffset", to=-5), INVALID, "byteOffset"),
    "accessor of no view": (gltf("accessors", 0, "bufferView", to=7), INVALID, "accessors.0"),
    "node of no mesh": (gltf("nodes", 0, "mesh", to=9), INVALID, "nodes.0.mesh is 9"),
    "node that is its own child": (gltf("nodes", 0, "children", to=[0]), INVALID, "cycle"),
    "scene of no node": (gltf("scenes", 0, "nodes", to=[5]), INVALID, "scenes.0.nodes is 5"),
    "scene that is not there": (gltf("scene", to=5), INVALID, "scene is 5"),
    "glTF of a list": ({"m.gltf": "[]"}, INVALID, "not a JSON object"),
    "glTF of infinity": (
        gltf("nodes", 0, "matrix", to=[float("inf")] * 16), INVALID, "Infinity is no number of JSON"
    ),
    "glTF of NaN": (
        gltf("nodes", 0, "matrix", to=[float("nan")] * 16), INVALID, "NaN is no number of JSON"
    ),
    "glTF beyond all numbers": (
        {"m.gltf": gltf("nodes", 0, "matrix", to=[2.0] * 16)["m.gltf"].replace("2.0", "1e400")},
        INVALID, "1e400 is no finite number",
    ),
    "glTF of no JSON": ({"m.gltf": "{"}, INVALID, "not JSON"),
    "OBJ face beyond": ({"m.obj": _V + "f 1 2 99999\n"}, INVALID, "face 1 names vertex 99999"),
    "OBJ of NaN": ({"m.obj": _V.replace("1", "nan", 1) + _F}, INVALID, "vertex 2"),
    "OBJ of nothing": ({"m.obj": ""}, "scene_invalid", "objects.0.shape"),
    "OBJ of noise": ({"m.obj": b"\xff\0\x01" * 100}, "scene_invalid", "objects.0.shape"),
    "sound VTK": ({"m.vtk": _VTK}, None, ""),
    "VTK cell beyond": (
        {"m.vtk": _VTK.replace("4 0 1 2 3", "4 0 1 2 99999")}, INVALID, "point 99999"
    ),
    "VTK of many points": (
        {"m.vtk": _VTK.replace("POINTS 4", "POINTS 4000000000")}, INVALID, "POINTS: 4000000000"
    ),
    "VTK of many cells": (
        {"m.vtk": _VTK.replace("CELLS 1 5", "CELLS 100000000 500000000")}, INVALID, "CELLS"
    ),
    "VTK of NaN": ({"m.vtk": _VTK.replace("1 0 0", "nan 0 0")}, INVALID, "POINTS"),
    "VTK in binary": ({"m.vtk": _VTK.replace("ASCII", "BINARY")}, INVALID, "BINARY"),
    "mesh of no kind": ({"m.txt": "hello"}, "scene_invalid", "objects.0.shape"),
}  # fmt: skip
FILES = {
    **{f"robot: {k}": v for k, v in ROBOTS.items()},
    **{f"mesh: {k}": v for k, v in MESHES.items()},
}
