"""How the body of a posted scene is documented: the same scene in JSON and in YAML."""

from typing import Any

_JSON: dict[str, Any] = {
    "name": "table_top",
    "robots": [{"name": "arm", "model": "ur5e", "positions": "home"}],
    "objects": [
        {
            "name": "table",
            "shape": {"box": [1.2, 0.8, 0.05]},
            "pose": {"position": [0.5, 0.0, -0.03]},
        },
        {
            "name": "can",
            "shape": {"cylinder": {"radius": 0.03, "length": 0.12}},
            "pose": {"position": [0.5, 0.2, 0.06]},
            "movable": True,
        },
    ],
    "frames": [
        {
            "name": "pick",
            "parent": "can",
            "pose": {"position": [0.0, 0.0, 0.05], "rpy": [3.14159265, 0.0, 0.0]},
        }
    ],
    "allowed_collisions": [["table", "arm::base_link"]],
    "margin": 0.0,
}

_YAML = """\
name: table_top
robots:
  - {name: arm, model: ur5e, positions: home}
objects:
  - name: table
    shape: {box: [1.2, 0.8, 0.05]}
    pose: {position: [0.5, 0.0, -0.03]}
  - name: can
    shape: {cylinder: {radius: 0.03, length: 0.12}}
    pose: {position: [0.5, 0.2, 0.06]}
    movable: true
frames:
  - {name: pick, parent: can, pose: {position: [0, 0, 0.05], rpy: [3.14159265, 0, 0]}}
allowed_collisions: [[table, "arm::base_link"]]
margin: 0.0
"""

REQUEST_BODY: dict[str, Any] = {
    "required": True,
    "description": "A scene document, at most 32 MB of JSON or 2 MB of YAML",
    "content": {
        "application/json": {
            "schema": {"$ref": "#/components/schemas/SceneDocument"},
            "examples": {"table_top": {"summary": "An arm at a table", "value": _JSON}},
        },
        "application/yaml": {
            "schema": {"type": "string", "description": "The same document as YAML 1.1"},
            "examples": {"table_top": {"summary": "An arm at a table", "value": _YAML}},
        },
    },
}
