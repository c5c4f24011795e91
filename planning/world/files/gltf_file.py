"""validate_gltf(): validation of a glTF's references (glTF 2.0, section 3.6).

The loader that Drake uses reads beyond the end of buffers, follows children in cycles, and takes
indices as they are; each of these ends the process.
"""

import base64
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from urllib.parse import unquote

_COMPONENT_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
_NUM_COMPONENTS = {
    "SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16,
}  # fmt: skip
# Fields by which an element of each list refers to others, and the list of these.
_POINTERS = {
    "bufferViews": {"buffer": "buffers"},
    "accessors": {"bufferView": "bufferViews"},
    "nodes": {"mesh": "meshes", "skin": "skins", "camera": "cameras"},
}


def validate_gltf(file: Path) -> None:
    """Raise unless every element that a glTF refers to exists.

    Raises:
        ValueError: One does not; the message names the element, such as `accessor 3`.
    """
    try:
        document = json.loads(
            file.read_bytes(), parse_constant=_refuse_constant, parse_float=_finite
        )
    except (ValueError, RecursionError) as fault:
        message = f"it is not JSON: {str(fault)[:200]}"
        raise ValueError(message) from fault
    if not isinstance(document, dict):
        message = "it is not a JSON object"
        raise ValueError(message)  # noqa: TRY004  (the caller's one kind of fault)
    _Gltf(document, file.parent).validate()


def _refuse_constant(word: str) -> float:
    """Raise on what Python's JSON has besides JSON's, and no other reader: NaN and Infinity."""
    message = f"{word} is no number of JSON"
    raise ValueError(message)


def _finite(word: str) -> float:
    number = float(word)
    if not math.isfinite(number):
        message = f"{word} is no finite number"
        raise ValueError(message)
    return number


class _Gltf:
    """glTF document, and the folder of its buffers."""

    def __init__(self, document: Mapping[str, Any], folder: Path) -> None:
        self._document = document
        self._folder = folder

    def validate(self) -> None:
        for name, pointers in _POINTERS.items():
            for i, part in enumerate(self._elements(name)):
                for field in pointers.keys() & part.keys():
                    self._element(pointers[field], part[field], f"{name}.{i}.{field}")
        checks = {
            "buffers": self._check_buffer,
            "bufferViews": self._check_view,
            "accessors": self._check_accessor,
            "meshes": self._check_mesh,
        }
        for name, check in checks.items():
            for i, part in enumerate(self._elements(name)):
                check(i, part)
        self._check_tree()

    def _elements(self, name: str) -> list[Mapping[str, Any]]:
        parts = self._document.get(name, [])
        if not isinstance(parts, list) or not all(isinstance(part, dict) for part in parts):
            message = f"`{name}` is not a list of objects"
            raise ValueError(message)
        return parts

    def _element(self, name: str, index: Any, where: str) -> Mapping[str, Any]:
        parts = self._elements(name)
        if isinstance(index, bool) or not isinstance(index, int) or not 0 <= index < len(parts):
            message = f"{where} is {index!r}, but the file has {len(parts)} {name}"
            raise ValueError(message)
        return parts[index]

    def _check_buffer(self, i: int, buffer: Mapping[str, Any]) -> None:
        length, uri = _size(buffer, "byteLength", f"buffers.{i}", minimum=1), buffer.get("uri", "")
        if not isinstance(uri, str) or not uri:
            message = f"buffers.{i}.uri is missing"
            raise ValueError(message)
        if uri.startswith("data:"):
            num_bytes = _data_length(uri, i)
        else:
            path = (self._folder / unquote(uri)).resolve()
            if "://" in uri or not path.is_relative_to(self._folder.resolve()):
                message = f"buffers.{i}.uri {uri[:80]!r} leaves the folder of the file"
                raise ValueError(message)
            if not path.is_file():
                message = f"buffers.{i}.uri {uri[:80]!r} does not exist in the folder of the file"
                raise ValueError(message)
            num_bytes = path.stat().st_size
        if num_bytes < length:
            message = f"buffers.{i} has {num_bytes} bytes, but its byteLength is {length}"
            raise ValueError(message)

    def _check_view(self, i: int, view: Mapping[str, Any]) -> None:
        where = f"bufferViews.{i}"
        buffer = self._element("buffers", view.get("buffer"), f"{where}.buffer")
        end = _size(view, "byteOffset", where, 0) + _size(view, "byteLength", where, minimum=1)
        if end > buffer["byteLength"]:
            message = f"{where} ends at byte {end} of a buffer of {buffer['byteLength']}"
            raise ValueError(message)

    def _check_accessor(self, i: int, accessor: Mapping[str, Any]) -> None:
        where = f"accessors.{i}"
        sizes = (accessor.get("componentType"), accessor.get("type"))
        if sizes[0] not in _COMPONENT_BYTES or sizes[1] not in _NUM_COMPONENTS:
            message = f"{where} has an unknown componentType or type: {list(sizes)}"
            raise ValueError(message)
        item = _COMPONENT_BYTES[sizes[0]] * _NUM_COMPONENTS[sizes[1]]
        count = _size(accessor, "count", where, minimum=1)
        if "bufferView" in accessor:
            self._check_span(where, accessor, item, count)
        elif "sparse" not in accessor:
            message = f"{where} has neither bufferView nor sparse"
            raise ValueError(message)
        if "sparse" in accessor:
            message = f"{where}.sparse is not supported: write out the values"
            raise ValueError(message)

    def _check_span(self, where: str, accessor: Mapping[str, Any], item: int, count: int) -> None:
        view = self._element("bufferViews", accessor["bufferView"], f"{where}.bufferView")
        stride = _size(view, "byteStride", "bufferViews", item)
        end = _size(accessor, "byteOffset", where, 0) + max(stride, item) * (count - 1) + item
        if end > view["byteLength"]:
            message = f"{where} ends at byte {end} of a bufferView of {view['byteLength']}"
            raise ValueError(message)

    def _check_mesh(self, i: int, mesh: Mapping[str, Any]) -> None:
        primitives = mesh.get("primitives")
        if not isinstance(primitives, list) or not primitives:
            message = f"meshes.{i} has no primitives"
            raise ValueError(message)
        for k, primitive in enumerate(primitives):
            where = f"meshes.{i}.primitives.{k}"
            attributes = primitive.get("attributes") if isinstance(primitive, dict) else None
            if not isinstance(attributes, dict) or "POSITION" not in attributes:
                message = f"{where} has no attribute POSITION"
                raise ValueError(message)
            for name, index in attributes.items():
                self._element("accessors", index, f"{where}.attributes.{name}")
            if "indices" in primitive:
                self._element("accessors", primitive["indices"], f"{where}.indices")

    def _check_tree(self) -> None:
        """Nodes have one parent at most, and none is its own ancestor."""
        children_seen: set[int] = set()
        children: dict[int, list[int]] = {}
        for i, node in enumerate(self._elements("nodes")):
            children[i] = self._indices(node.get("children", []), f"nodes.{i}.children")
            is_repeated = len(set(children[i])) < len(children[i])
            has_other_parent = not children_seen.isdisjoint(children[i])
            children_seen.update(children[i])
            if is_repeated or has_other_parent:
                message = f"nodes.{i}.children: a node has two parents, or is listed twice"
                raise ValueError(message)
        pending, num_visited = [i for i in children if i not in children_seen], 0
        while pending:
            num_visited += 1
            pending += children[pending.pop()]
        if num_visited < len(children):
            message = "nodes: the `children` form a cycle"
            raise ValueError(message)
        for i, scene in enumerate(self._elements("scenes")):
            self._indices(scene.get("nodes", []), f"scenes.{i}.nodes")
        if "scene" in self._document:
            self._element("scenes", self._document["scene"], "scene")

    def _indices(self, indices: Any, where: str) -> list[int]:
        if not isinstance(indices, list):
            message = f"{where} is not a list"
            raise ValueError(message)  # noqa: TRY004
        for index in indices:
            self._element("nodes", index, where)
        return indices


def _size(
    part: Mapping[str, Any], field: str, where: str, default: int | None = None, minimum: int = 0
) -> int:
    """Return a whole number of bytes or items."""
    value = part.get(field, default)
    if isinstance(value, bool) or not isinstance(value, int) or not minimum <= value < 2**40:
        message = f"{where}.{field} is {value!r}, which is not a valid size"
        raise ValueError(message)
    return value


def _data_length(uri: str, i: int) -> int:
    head, _, text = uri.partition(",")
    if not head.endswith(";base64"):
        message = f"buffers.{i}.uri is not base64 data"
        raise ValueError(message)
    try:
        return len(base64.b64decode(text, validate=True))
    except ValueError as fault:
        message = f"buffers.{i}.uri is not base64 data: {fault}"
        raise ValueError(message) from fault
