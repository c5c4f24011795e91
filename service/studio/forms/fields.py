"""Fields: what a JSON Schema lets be filled in, as a tree of values."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Field:
    """Something that is filled in.

    Attributes:
        name: In the JSON, or of the alternative; empty for an item of a list.
        text: What it means.
        default: What it is if it is left out; None if that says nothing.
        is_required: Whether it must not be left out.
    """

    name: str
    text: str
    default: Any
    is_required: bool


@dataclass(frozen=True)
class Flag(Field):
    """Yes or no."""


@dataclass(frozen=True)
class Choice(Field):
    """One of several words."""

    options: tuple[str, ...]


@dataclass(frozen=True)
class Number(Field):
    """A number between bounds, both of which it may have; the lower one may be excluded."""

    lower: float | None
    upper: float | None
    excludes_lower: bool
    is_whole: bool


@dataclass(frozen=True)
class Text(Field):
    """A word or more."""

    longest: int


@dataclass(frozen=True)
class Vector(Field):
    """Three numbers between bounds."""

    lower: float | None
    upper: float | None
    excludes_lower: bool


@dataclass(frozen=True)
class Written(Field):
    """A list or a map of values, written by hand as in YAML.

    Attributes:
        schema: Of it, with `$ref` into the document.
    """

    schema: Mapping[str, Any]


@dataclass(frozen=True)
class Group(Field):
    """Several fields, of which each has a name."""

    fields: tuple[Field, ...]


@dataclass(frozen=True)
class Optional(Field):
    """Something that may be null."""

    inner: Field


@dataclass(frozen=True)
class Items(Field):
    """A list of things of one kind.

    Attributes:
        inner: An item.
        fewest: At least as many.
        most: At most as many.
    """

    inner: Field
    fewest: int
    most: int


@dataclass(frozen=True)
class OneOf(Field):
    """One of several things.

    Attributes:
        alternatives: Each with a name of its own.
        tag: Name of the property that says which one it is; empty if its form does.
    """

    alternatives: tuple[Field, ...]
    tag: str
