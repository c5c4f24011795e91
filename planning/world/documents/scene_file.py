"""Scene parser: YAML, JSON or a decoded document, with the line of every fault."""

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, cast

import yaml
from pydantic import ValidationError

from planning.domain.scene.scene import Scene
from planning.errors import AssetNotFound, SceneInvalid
from planning.world.documents.document_faults import faults_of
from planning.world.documents.scene_document import SceneDocument
from planning.world.documents.yaml_text import read_yaml

# A scene of a thousand obstacles is 100 kB; libyaml's tree of 8 MB takes minutes and gigabytes.
MAX_TEXT_BYTES = 4_000_000
_MAX_FAULTS = 20


def parse_scene(source: str | bytes | Mapping[str, Any], name: str = "the scene") -> Scene:
    """Return the scene of a text or a decoded document.

    Args:
        source: YAML or JSON text, or a mapping.
        name: Name of the source in messages, for example a file name.

    Raises:
        SceneInvalid: With the `path` of every fault and, for text, its `line`.
    """
    return read_document(source, name).value()


def read_document(
    source: str | bytes | Mapping[str, Any], name: str = "the scene"
) -> SceneDocument:
    """Return the document in a text or a decoded document; raises as `parse_scene`."""
    if isinstance(source, Mapping):
        return _validate(source, None, name)
    if len(source) > MAX_TEXT_BYTES:
        message = f"{name} has {len(source)} bytes; at most {MAX_TEXT_BYTES} are read"
        raise SceneInvalid(message, {"bytes": len(source), "bound": MAX_TEXT_BYTES})
    try:
        document, node = read_yaml(source)
    except yaml.YAMLError as fault:
        raise _yaml_error(fault, name) from fault
    if not isinstance(document, Mapping):
        kind = type(document).__name__
        message = f"{name} must be a mapping with the key `robots`, not {kind}"
        raise SceneInvalid(message, {"path": "", "line": 1})
    return _validate(document, node, name)


def read_scene(path: Path) -> Scene:
    """Return the scene in a file.

    Raises:
        AssetNotFound: There is no such file.
        SceneInvalid: It is not a scene.
    """
    try:
        text = path.read_bytes()
    except OSError as fault:
        message = f"cannot read the scene {path}: {fault.strerror}"
        raise AssetNotFound(message, {"uri": str(path)}) from fault
    return parse_scene(text, path.name)


def with_line(fault: SceneInvalid, source: str | bytes) -> SceneInvalid:
    """Return an error found after parsing, with the line of its `path` in the text.

    `load_world` finds faults that the text alone does not show, such as a frame whose parent is no
    link of the robot; it has the path, and this adds the line.
    """
    path = fault.evidence.get("path")
    if not path or fault.evidence.get("line"):
        return fault
    steps = [int(step) if step.isdigit() else step for step in str(path).split(".")]
    line = _line_of(yaml.compose(source, Loader=yaml.CSafeLoader), steps)
    return SceneInvalid(f"line {line}: {fault.detail}", {**fault.evidence, "line": line})


def _validate(document: Mapping[str, Any], node: Any, name: str) -> SceneDocument:
    try:
        return SceneDocument.model_validate(document)
    except ValidationError as refusal:
        found = refusal.errors(include_url=False)
    all_faults = faults_of(cast("Any", found), document, _schema())
    # Finding a line takes time proportional to the text: of many faults only the first get one.
    faults = [
        {
            "path": fault.path,
            "pointer": fault.pointer,
            "line": _line_of(node, fault.steps),
            "message": fault.message,
            "nearest": list(fault.nearest),
        }
        for fault in all_faults[:_MAX_FAULTS]
    ]
    first = faults[0]
    where = f", line {first['line']}" if first["line"] else ""
    more = f" (and {len(all_faults) - 1} more faults)" if len(all_faults) > 1 else ""
    place = first["path"] or "the document"
    message = f"{name}{where}: {place}: {first['message']}{more}"
    evidence = {"path": first["path"], "pointer": first["pointer"], "line": first["line"]}
    raise SceneInvalid(message, {**evidence, "faults": faults})


@cache
def _schema() -> dict[str, Any]:
    return SceneDocument.model_json_schema()


def _line_of(node: Any, location: Sequence[str | int]) -> int | None:
    """Return the line (from 1) of the deepest part of `location` that the text has."""
    if node is None:
        return None
    line: int = node.start_mark.line
    for step in location:
        children = _children(node)
        if step not in children:
            continue  # an artificial step of pydantic's, such as the branch of a union
        line, node = children[step]
    return line + 1


def _children(node: Any) -> dict[str | int, tuple[int, Any]]:
    """Return the line and the node of every child, by key or index."""
    if isinstance(node, yaml.MappingNode):
        return {key.value: (key.start_mark.line, child) for key, child in node.value}
    if isinstance(node, yaml.SequenceNode):
        return {i: (child.start_mark.line, child) for i, child in enumerate(node.value)}
    return {}


def _yaml_error(fault: Exception, name: str) -> SceneInvalid:
    """Return our error for text that is not YAML."""
    mark = getattr(fault, "problem_mark", None)
    if mark is not None:
        problem = getattr(fault, "problem", None) or "not YAML"
        line = mark.line + 1
        return SceneInvalid(f"{name}, line {line}: {problem}", {"path": "", "line": line})
    text = str(fault)[:300]
    digits = text.removeprefix("line ").split(":", 1)[0]
    line = int(digits) if text.startswith("line ") and digits.isdigit() else None
    return SceneInvalid(f"{name}: {text}", {"path": "", "line": line})
