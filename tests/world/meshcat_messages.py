"""What a page of Meshcat's tells its viewer: messages, and the motion that it plays."""

import base64
import json
import re
import struct

import numpy as np

from planning.domain.geometry import rotation


def messages(page: str) -> list[dict]:
    """Return what Meshcat is told when the page opens, in order."""
    found = re.findall(r"data:application/octet-binary;base64,([A-Za-z0-9+/=]+)", page)
    return [_unpacked(base64.b64decode(text), 0)[0] for text in found]


def animation(page: str) -> dict:
    """Return the one animation of a page."""
    (message,) = [message for message in messages(page) if message["type"] == "set_animation"]
    return message


def tracks(page: str) -> dict[str, np.ndarray]:
    """Return X_WF over the frames of everything that the page moves, by path, (n, 4, 4)."""
    found = {}
    for entry in animation(page)["animations"]:
        keys = {track["name"]: track["keys"] for track in entry["clip"]["tracks"]}
        if ".position" not in keys:
            continue
        poses = np.tile(np.eye(4), (len(keys[".position"]), 1, 1))
        poses[:, :3, 3] = [key["value"] for key in keys[".position"]]
        turns = [np.roll(key["value"], 1) for key in keys[".quaternion"]]  # has w last
        poses[:, :3, :3] = rotation.matrix(np.array(turns))
        found[entry["path"]] = poses
    return found


def overlay(page: str) -> dict:
    """Return what the page names: its title, labels and sections."""
    (data,) = re.findall(r"const told = (\{.*\});\n", page)
    return json.loads(data)


def _unpacked(data: bytes, at: int) -> tuple:
    """Return a value and where the next begins, by the specification of MessagePack."""
    code = data[at]
    at += 1
    if code < 0x80 or code >= 0xE0:
        return (code if code < 0x80 else code - 256), at
    if code in _NUMBERS:
        kind = ">" + _NUMBERS[code]
        return struct.unpack_from(kind, data, at)[0], at + struct.calcsize(kind)
    if code in {0xC0, 0xC2, 0xC3}:
        return {0xC0: None, 0xC2: False, 0xC3: True}[code], at
    if code < 0xC0:  # short maps, arrays and texts
        kind = "map" if code < 0x90 else "array" if code < 0xA0 else "text"
        return _many(data, at, kind, code & (0x1F if kind == "text" else 0x0F))
    kind, size = _LENGTHS[code]
    count = int.from_bytes(data[at : at + size])
    return _many(data, at + size, kind, count)


def _many(data: bytes, at: int, kind: str, count: int) -> tuple:
    if kind in {"text", "bytes", "extension"}:
        at += kind == "extension"  # its type
        part = data[at : at + count]
        return (part.decode() if kind == "text" else part), at + count
    parts = []
    for _ in range(count * (2 if kind == "map" else 1)):
        part, at = _unpacked(data, at)
        parts.append(part)
    return (dict(zip(parts[::2], parts[1::2], strict=True)) if kind == "map" else parts), at


_NUMBERS = dict(zip(range(0xCA, 0xD4), "fdBHIQbhiq", strict=True))
_LENGTHS = {
    **{0xC4 + i: ("bytes", 2**i) for i in range(3)},
    **{0xC7 + i: ("extension", 2**i) for i in range(3)},
    **{0xD9 + i: ("text", 2**i) for i in range(3)},
    **{0xDC + i: ("array", 2 + 2 * i) for i in range(2)},
    **{0xDE + i: ("map", 2 + 2 * i) for i in range(2)},
}
