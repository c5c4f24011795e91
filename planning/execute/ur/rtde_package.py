"""RTDE packages: what the protocol's client and controller send each other, as bytes.

A package is its size (uint16), its type (one byte) and what it carries, in network byte order
(Universal Robots, Real-Time Data Exchange guide, protocol version 2). A recipe is the list of
fields that the data packages of one direction carry.
"""

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum

PROTOCOL_VERSION = 2
_HEADER = struct.Struct(">HB")
_FORMATS = {
    "BOOL": "?",
    "UINT8": "B",
    "UINT32": "I",
    "UINT64": "Q",
    "INT32": "i",
    "DOUBLE": "d",
    "VECTOR3D": "3d",
    "VECTOR6D": "6d",
    "VECTOR6INT32": "6i",
    "VECTOR6UINT32": "6I",
}

_SCALARS = {"BOOL", "UINT8", "UINT32", "UINT64", "INT32", "DOUBLE"}

type FieldValue = float | tuple[float, ...]


class PackageType(IntEnum):
    """Types of packages, by the letter that stands for each."""

    REQUEST_PROTOCOL_VERSION = ord("V")
    TEXT_MESSAGE = ord("M")
    DATA = ord("U")
    SETUP_OUTPUTS = ord("O")
    SETUP_INPUTS = ord("I")
    START = ord("S")
    PAUSE = ord("P")


def encode(kind: PackageType, content: bytes = b"") -> bytes:
    """Return a package."""
    return _HEADER.pack(_HEADER.size + len(content), kind) + content


@dataclass
class PackageReader:
    """Cuts a stream of bytes into packages.

    Attributes:
        buffer: Bytes that are no whole package yet.
    """

    buffer: bytes = b""

    def feed(self, received: bytes) -> None:
        """Take what has come."""
        self.buffer += received

    def next(self) -> tuple[int, bytes] | None:
        """Return type and content of the next package; None until it is whole.

        Raises:
            ValueError: The bytes are not of this protocol.
        """
        if len(self.buffer) < _HEADER.size:
            return None
        size, kind = _HEADER.unpack_from(self.buffer)
        if size < _HEADER.size:
            message = f"a package of {size} bytes is shorter than its header"
            raise ValueError(message)
        if len(self.buffer) < size:
            return None
        content, self.buffer = self.buffer[_HEADER.size : size], self.buffer[size:]
        return kind, content


@dataclass(frozen=True)
class Recipe:
    """Fields of the data packages of one direction, as the controller has agreed to them.

    Attributes:
        identifier: Number of the recipe.
        names: Of its fields.
        types: Of its fields, in the protocol's words.
    """

    identifier: int
    names: tuple[str, ...]
    types: tuple[str, ...]

    @classmethod
    def agreed(cls, names: Sequence[str], answer: bytes) -> "Recipe":
        """Return the recipe of the controller's answer to a setup.

        Raises:
            ValueError: The controller does not have some field, or another client writes it.
        """
        types = tuple(answer[1:].decode("ascii").split(","))
        wrong = [f"{n} ({t})" for n, t in zip(names, types, strict=False) if t not in _FORMATS]
        if wrong or len(types) != len(names):
            message = f"the controller does not give {', '.join(wrong) or 'all fields'}"
            raise ValueError(message)
        return cls(answer[0], tuple(names), types)

    def pack(self, values: Mapping[str, FieldValue]) -> bytes:
        """Return a data package of a value for each field."""
        content = bytes([self.identifier])
        for name, kind in zip(self.names, self.types, strict=True):
            value = values[name]
            numbers = value if isinstance(value, tuple) else (value,)
            whole = kind not in {"DOUBLE", "VECTOR3D", "VECTOR6D"}
            content += struct.pack(
                f">{_FORMATS[kind]}", *(int(x) if whole else float(x) for x in numbers)
            )
        return encode(PackageType.DATA, content)

    def unpack(self, content: bytes) -> dict[str, FieldValue]:
        """Return the values of a data package.

        Raises:
            ValueError: It is of another recipe, or has another length.
        """
        layout = struct.Struct(">" + "".join(_FORMATS[kind] for kind in self.types))
        if len(content) != 1 + layout.size or content[0] != self.identifier:
            message = "a data package is not of the recipe that was agreed to"
            raise ValueError(message)
        values: dict[str, FieldValue] = {}
        at = 1
        for name, kind in zip(self.names, self.types, strict=True):
            part = struct.Struct(f">{_FORMATS[kind]}")
            numbers = part.unpack_from(content, at)
            at += part.size
            values[name] = numbers[0] if kind in _SCALARS else numbers
        return values
