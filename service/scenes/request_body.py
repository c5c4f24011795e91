"""The body of a posted scene: which language it is in, its text, and how it is documented."""

import hashlib
from typing import Any

from fastapi import Request

from service.api.routing.strict_route import kind_of
from service.errors import BodyTooLarge, UnreadableBody, UnsupportedMediaType
from service.jobs.job import IdempotencyKey
from service.scenes.tasks import Media

YAML_TYPES = ("application/yaml", "application/x-yaml", "text/yaml", "text/x-yaml")
# YAML is for what people write; libyaml needs seconds for what machines do.
MAX_YAML_BYTES = 2_000_000

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


async def read_scene_body(request: Request) -> tuple[str, Media]:
    """Return the text of a scene and its language.

    Raises:
        UnsupportedMediaType: The content type is neither JSON nor YAML.
        BodyTooLarge: It is YAML, and long.
        UnreadableBody: It is not UTF-8.
    """
    media = media_of(request.headers.get("content-type", "application/json"))
    body = await request.body()
    if media == "yaml" and len(body) > MAX_YAML_BYTES:
        message = f"{len(body)} bytes of YAML; at most {MAX_YAML_BYTES} are read, post JSON instead"
        raise BodyTooLarge(message, {"bytes": len(body), "bound": MAX_YAML_BYTES})
    try:
        return body.decode("utf-8"), media
    except UnicodeDecodeError as fault:
        message = f"the body is not UTF-8: {fault.reason} at byte {fault.start}"
        raise UnreadableBody(message, {"position": fault.start}) from fault


def key_of(key: str, text: str, media: Media) -> IdempotencyKey:
    """Return an idempotency key with all that tells a posted scene from another one."""
    sha256 = hashlib.sha256(text.encode()).hexdigest()
    return IdempotencyKey(key, {"media": media, "sha256": sha256})


def media_of(content_type: str) -> Media:
    """Return the language that a content type stands for.

    Raises:
        UnsupportedMediaType: None that is read here.
    """
    kind = kind_of(content_type)
    if kind == "application/json" or kind.endswith("+json"):
        return "json"
    if kind in YAML_TYPES or kind.endswith("+yaml"):
        return "yaml"
    known = ["application/json", *YAML_TYPES]
    detail = f"scenes are read as {' or '.join(known)}, not {kind}"
    raise UnsupportedMediaType(detail, {"got": kind, "known": known})
