"""Texts of scenes: YAML or JSON, refused early if they are bombs."""

from collections.abc import Mapping
from typing import Any

from planning.errors import SceneInvalid
from planning.world.documents.scene_document import SceneDocument
from planning.world.documents.scene_file import read_document
from service.api.routing.json_body import RepeatedKey
from service.api.routing.json_body import decode_json as decode
from service.errors import UnreadableBody

# Ten thousand obstacles have 200,000 values. Every fault of a document costs a kilobyte and ten
# microseconds to report, so a list or an object of any length could be all faults.
MAX_VALUES = 300_000
MAX_CHILDREN = 20_000
MAX_DEPTH = 64
# libyaml's tree costs 20 microseconds a token; JSON has no such cost.
MAX_YAML_TOKENS = 100_000


def decode_scene(text: str, media: str) -> SceneDocument:
    """Return the document of a scene in a text, with the defaults filled in.

    Args:
        text: What was posted.
        media: `json` or `yaml`.

    Raises:
        UnreadableBody: It is not JSON.
        SceneInvalid: It is no scene, with the `path` and, for YAML, the `line` of the fault.
    """
    if media == "json":
        return read_document(decode_json(text))
    _refuse_long(text)
    return read_document(text)


def decode_json(text: str) -> Mapping[str, Any]:
    """Return the object in a JSON text.

    Raises:
        UnreadableBody: It is not JSON.
        SceneInvalid: It is no object, or gives a key twice, or is absurdly large.
    """
    try:
        decoded = decode(text)
    except RepeatedKey as repeated:
        fault = repeated.fault
        message = f"the scene: {fault.path}: {fault.message}"
        raise SceneInvalid(message, {"path": fault.path, "pointer": fault.pointer}) from repeated
    except (ValueError, RecursionError) as fault:
        reason = str(fault)[:200] or type(fault).__name__
        message = f"the body is not JSON: {reason}"
        raise UnreadableBody(message, {"reason": reason}) from fault
    if not isinstance(decoded, Mapping):
        message = f"the scene must be an object with the key `robots`, not {type(decoded).__name__}"
        raise SceneInvalid(message, {"path": ""})
    _refuse_absurd(decoded)
    return decoded


def _refuse_long(text: str) -> None:
    """Raise on YAML that would take seconds to read."""
    tokens = sum(text.count(mark) for mark in "\n,:")
    if tokens > MAX_YAML_TOKENS:
        message = f"the scene is too long for YAML ({tokens} lines, commas and colons); post JSON"
        raise SceneInvalid(message, {"path": "", "tokens": tokens, "bound": MAX_YAML_TOKENS})


def _refuse_absurd(document: Mapping[str, Any]) -> None:
    """Raise on more values, longer lists or deeper nesting than any scene has."""
    count = 0
    level: list[Any] = [document]
    for _ in range(MAX_DEPTH):
        below: list[Any] = []
        for parent in level:
            children = _children(parent)
            if len(children) > MAX_CHILDREN:
                raise _absurd("items in one list or object", MAX_CHILDREN)
            below += children
        count += len(below)
        if count > MAX_VALUES:
            raise _absurd("values", MAX_VALUES)
        if not below:
            return
        level = below
    raise _absurd("levels of nesting", MAX_DEPTH)


def _absurd(what: str, bound: int) -> SceneInvalid:
    return SceneInvalid(f"the scene has more than {bound} {what}", {"path": "", "bound": bound})


def _children(parent: Any) -> list[Any]:
    if isinstance(parent, dict):
        return list(parent.values())
    return parent if isinstance(parent, list) else []
