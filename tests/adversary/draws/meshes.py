"""Meshes of a box in the formats that robots name, written by hand from their specifications."""

import base64
import json
import struct

import numpy as np

TRIANGLES = np.array([
    [0, 1, 3],
    [0, 3, 2],
    [4, 6, 7],
    [4, 7, 5],
    [0, 4, 5],
    [0, 5, 1],
    [2, 3, 7],
    [2, 7, 6],
    [0, 2, 6],
    [0, 6, 4],
    [1, 5, 7],
    [1, 7, 3],
])


def box_corners(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the corners of a box, shape (8, 3)."""
    ends = np.array([low, high])
    return np.array([
        [ends[i, 0], ends[j, 1], ends[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)
    ])


def obj(corners: np.ndarray, triangles: np.ndarray = TRIANGLES) -> bytes:
    rows = [f"v {x!r} {y!r} {z!r}" for x, y, z in corners.tolist()]
    rows += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles.tolist()]
    return ("\n".join(rows) + "\n").encode()


def stl(corners: np.ndarray) -> bytes:
    """Return a binary STL."""
    rows = [bytes(80), struct.pack("<I", len(TRIANGLES))]
    rows += [struct.pack("<12fH", 0, 0, 0, *t.reshape(-1), 0) for t in corners[TRIANGLES]]
    return b"".join(rows)


def dae(corners: np.ndarray, unit: float, up: str) -> bytes:
    """Return COLLADA whose numbers are in `unit` metres, with an axis up."""
    numbers = " ".join(repr(float(x)) for x in corners.reshape(-1))
    faces = " ".join(str(i) for i in TRIANGLES.reshape(-1))
    return f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2000-01-01T00:00:00</created><modified>2000-01-01T00:00:00</modified>
<unit name="own" meter="{unit!r}"/><up_axis>{up}</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="24">{numbers}</float_array><technique_common>
<accessor source="#pa" count="8" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="12"><input semantic="VERTEX" source="#v" offset="0"/><p>{faces}</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
""".encode()


def _gltf_document(corners: np.ndarray) -> tuple[dict, bytes]:
    points = corners.astype("<f4")
    data = points.tobytes() + TRIANGLES.astype("<u2").tobytes()
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(data)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 96, "target": 34962},
            {"buffer": 0, "byteOffset": 96, "byteLength": 72, "target": 34963},
        ],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": 5126,
                "count": 8,
                "type": "VEC3",
                "min": points.min(axis=0).tolist(),
                "max": points.max(axis=0).tolist(),
            },
            {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"},
        ],
    }
    return document, data


def gltf(corners: np.ndarray) -> bytes:
    document, data = _gltf_document(corners)
    text = base64.b64encode(data).decode()
    document["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{text}"
    return json.dumps(document).encode()


def glb(corners: np.ndarray) -> bytes:
    document, data = _gltf_document(corners)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    data += bytes(-len(data) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    chunks += struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks
