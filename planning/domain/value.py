"""Value: a frozen dataclass that compares, hashes and pickles by content."""

import dataclasses
import hashlib
import math
import struct
from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from functools import cache, lru_cache
from types import NoneType, UnionType
from typing import Any, ClassVar, Literal, TypeAliasType, cast, get_args, get_origin, override

import numpy as np

# Type of row indices.
_ROWS = np.dtype(np.int32)
# Numbers, truth values and text of fixed width. Long doubles have padding bytes.
_ARRAYS = frozenset("?bBhHiIlLqQefdFDSU")
# Annotations of fields that are no arrays, by their origin.
_NO_ARRAYS = frozenset({tuple, list, dict, set, frozenset, Mapping, Callable, Literal})
# Texts of fewer characters are mostly names.
_SHORT = 64
_PACKED = struct.Struct("<d").pack
# Attribute in which a value of a class with `caches_bytes` keeps its bytes.
_BYTES_ATTRIBUTE = "_fed_bytes"


def frozen(array: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return a read-only float64 copy, or the array itself if it is one already."""
    if isinstance(array, np.ndarray) and array.base is None and array.dtype.char == "d":
        flags = array.flags
        if not flags.writeable and flags.c_contiguous:
            return array
    copy = np.array(array, dtype=np.float64, order="C")
    copy.setflags(write=False)
    return copy


def _frozen_rows(rows: Any) -> Any:
    """Return a read-only copy of row indices."""
    copy = np.array(rows, order="C")
    copy.flags.writeable = False
    return copy


def _are_same(array: Any, other: Any) -> bool:
    """Return whether two arrays are equal, bit for bit."""
    return (
        isinstance(other, np.ndarray)
        and array.shape == other.shape
        and array.dtype == other.dtype
        and array.tobytes() == other.tobytes()
    )


def _frozen_array(array: Any) -> Any:
    return _frozen_rows(array) if array.dtype == _ROWS else frozen(array)


class Value:
    """Base class of all values; subclasses are `@dataclass(frozen=True, eq=False)`.

    Arrays are float64, copied and read-only from construction on and again after unpickling
    (numpy drops the flag on the way); int32 stays int32, for row indices. Equality is equality
    of content, bit for bit.

    A class whose instances enter digest after digest unchanged, by the thousand in a scene or with
    every plan of a world, may set `caches_bytes`: the bytes that an instance adds to a digest are
    then computed once. Fields in `left_out_if_empty` enter a digest only with content, so a field
    that is added later does not change the digests of the values that do not use it.
    """

    caches_bytes: ClassVar[bool] = False
    left_out_if_empty: ClassVar[frozenset[str]] = frozenset()

    def __post_init__(self) -> None:
        """Freeze every array."""
        fields = self.__dict__
        for name in _array_fields(type(self)):
            item = fields.get(name)
            if isinstance(item, np.ndarray):
                fields[name] = _frozen_array(item)

    def _freeze(self, state: Mapping[str, Any]) -> None:
        for name, item in list(state.items()):
            content = _frozen_array(item) if isinstance(item, np.ndarray) else item
            object.__setattr__(self, name, content)

    @override
    def __getstate__(self) -> dict[str, Any]:
        """Return the fields alone, without cached properties."""
        return {name: item for name, item in self.__dict__.items() if name != _BYTES_ATTRIBUTE}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore from a pickle with the arrays frozen again."""
        self._freeze(state)

    @override
    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return self is other or (
            not self._has_other_arrays(other) and digest(self) == digest(other)
        )

    def _has_other_arrays(self, other: object) -> bool:
        """Return whether an array differs; quicker than comparing digests of all content."""
        return any(
            isinstance(item, np.ndarray) and not _are_same(item, getattr(other, field.name))
            for field in dataclasses.fields(cast("Any", self))
            for item in [getattr(self, field.name)]
        )

    @override
    def __hash__(self) -> int:
        return hash(digest(self))


@cache
def _array_fields(kind: type[Any]) -> tuple[str, ...]:
    """Return the fields of a class that may be arrays by their annotations; most have none."""
    return tuple(field.name for field in dataclasses.fields(kind) if _may_be_array(field.type))


def _may_be_array(annotation: Any) -> bool:
    if isinstance(annotation, TypeAliasType):
        return _may_be_array(annotation.__value__)
    if isinstance(annotation, UnionType):
        return any(map(_may_be_array, get_args(annotation)))
    if get_origin(annotation) is not None:
        return get_origin(annotation) not in _NO_ARRAYS
    if isinstance(annotation, type):
        return not issubclass(annotation, (float, int, str, NoneType, Enum, Value))
    return True


def digest(content: Any) -> str:
    """Return the sha256 (hex) of values, arrays, containers and scalars, by content.

    Different content has another digest: floats enter as their IEEE-754 bytes, integers exactly
    (one that a float can hold is the same number as that float), and every part enters with its
    type and length. Two values of different classes never share a digest.

    Raises:
        TypeError: A part of it is not a value.
    """
    # Joined first: to update a hash with a few bytes takes longer than to keep them.
    buffer = _Bytes()
    _feed(buffer, content)
    return hashlib.sha256(b"".join(buffer.parts)).hexdigest()


def _feed(buffer: Any, content: Any) -> None:
    # Most parts of a value are of these types, so these are tested first.
    scalar = _SCALARS.get(type(content))
    if scalar is not None:
        buffer.update(scalar(content))
    elif isinstance(content, Value):
        if content.caches_bytes:
            buffer.update(_cached_bytes(content))
        else:
            _feed_value(buffer, content)
    elif type(content) is tuple:
        _feed_all(buffer, "list", content)
    else:
        _feed_other(buffer, content)


def _feed_other(buffer: Any, content: Any) -> None:
    match content:
        case np.ndarray():
            _validate_dtype(content)
            buffer.update(_array_header(content.dtype.str, content.shape))
            buffer.update(content.tobytes())  # in the order of C, whatever its own is
        case Mapping():
            items = [part for key in sorted(content) for part in (key, content[key])]
            _feed_all(buffer, "map", items)
        case tuple() | list():
            _feed_all(buffer, "list", content)
        case _:
            buffer.update(_scalar(content))


@lru_cache(256)
def _array_header(dtype: str, shape: tuple[int, ...]) -> bytes:
    return f"array{dtype}{shape}".encode()


def _validate_dtype(array: Any) -> None:
    """Raise on arrays whose bytes are not their content: addresses, padding, unnamed fields."""
    if array.dtype.char not in _ARRAYS:
        message = f"an array of {array.dtype} is not a value and has no digest"
        raise TypeError(message)


def _feed_value(buffer: Any, content: Any) -> None:
    """Feed the same bytes as a list of all fields' names and contents."""
    left_out = content.left_out_if_empty
    empty = left_out and frozenset(name for name in left_out if not getattr(content, name))
    kind, fields = _class_header(type(content), empty)
    buffer.update(kind)
    for name, encoded_name in fields:
        item = getattr(content, name)
        scalar = _SCALARS.get(type(item))
        if scalar is None:
            buffer.update(encoded_name)
            _feed(buffer, item)
        else:
            buffer.update(encoded_name + scalar(item))


@cache
def _class_header(
    kind: type[Any], left_out: frozenset[str]
) -> tuple[bytes, tuple[tuple[str, bytes], ...]]:
    """Return the leading bytes of a class, and its fields' names with their own bytes."""
    names = [field.name for field in dataclasses.fields(kind) if field.name not in left_out]
    begin = f"value {kind.__qualname__}({2 * len(names)})".encode()
    return begin, tuple((name, _scalar(name)) for name in names)


class _Bytes:
    """Buffer of the bytes of a value; `update` adds some."""

    def __init__(self) -> None:
        self.parts: list[bytes] = []
        self.update = self.parts.append


def _cached_bytes(content: Any) -> bytes:
    """Return the bytes that a value adds to a digest, cached in the value itself."""
    cached = content.__dict__.get(_BYTES_ATTRIBUTE)
    if cached is None:
        own = _Bytes()
        _feed_value(own, content)
        cached = content.__dict__[_BYTES_ATTRIBUTE] = b"".join(own.parts)
    return cached


def _feed_all(buffer: Any, kind: str, items: Sequence[Any]) -> None:
    buffer.update(f"{kind}({len(items)})".encode())
    kinds = set(map(type, items))
    if len(kinds) == 1 and getattr(kinds.pop(), "caches_bytes", False):
        buffer.update(
            b"".join([item.__dict__.get(_BYTES_ATTRIBUTE) or _cached_bytes(item) for item in items])
        )
        return
    for item in items:
        _feed(buffer, item)


def _scalar(content: Any) -> bytes:
    match content:
        case Enum():
            return _scalar(content.value)
        case None | bool():
            return f"atom{content}".encode()
        case int() | np.integer():
            return _integer(int(content))
        case float():
            return b"number" + struct.pack("<d", content)
        case np.floating() if content.dtype.char in _ARRAYS:
            return b"number" + struct.pack("<d", float(content))
        case str():
            return _text(content)
        case _:
            message = f"{type(content).__name__} is not a value and has no digest"
            raise TypeError(message)


def _text(content: str) -> bytes:
    return _name(content) if len(content) < _SHORT else _any_text(content)


def _any_text(content: str) -> bytes:
    return f"text{len(content)}:{content}".encode("utf-8", "surrogatepass")


def _integer(number: int) -> bytes:
    """Return the bytes of the float that equals a number; its digits if none does."""
    try:
        nearest = float(number)
    except OverflowError:
        nearest = math.inf
    if nearest == number:
        return b"number" + struct.pack("<d", nearest)
    return f"integer{number:x};".encode()


def _float(number: float) -> bytes:
    return b"number" + _PACKED(number)


def _atom(content: bool | None) -> bytes:  # noqa: FBT001  (it is content)
    return b"atomNone" if content is None else b"atomTrue" if content else b"atomFalse"


# Names come again and again, in value after value.
_name = lru_cache(4096)(_any_text)
# What adds a scalar of exactly this type.
_SCALARS: Mapping[type[Any], Callable[[Any], bytes]] = {
    float: _float,
    str: _text,
    int: _integer,
    bool: _atom,
    type(None): _atom,
}
