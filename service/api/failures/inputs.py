"""Evidence of requests whose content has a fault: scenes, models, names, numbers."""

from typing import NotRequired, TypedDict

from pydantic import with_config

from service.api.failures.parts import OPEN


@with_config(OPEN)
class DocumentFault(TypedDict):
    """One fault of a document or of a parameter."""

    path: str
    """Its place, as names and numbers with dots"""
    pointer: str
    """The same as a JSON pointer (RFC 6901); empty for the root and for parameters"""
    message: str
    """What is wrong there, for a person"""
    nearest: NotRequired[list[str]]
    """Names that were perhaps meant, the nearest first"""
    line: NotRequired[int | None]
    """In the text, from 1; null where it is not known"""
    type: NotRequired[str]
    """Kind of the fault, as the library calls it that checks documents"""


@with_config(OPEN)
class SceneFaultEvidence(TypedDict):
    """Where a scene document has a fault."""

    path: NotRequired[str]
    """Its place, as names and numbers with dots; empty for the root"""
    pointer: NotRequired[str]
    """The same as a JSON pointer"""
    line: NotRequired[int | None]
    """In the text, from 1; null where it is not known"""
    faults: NotRequired[list[DocumentFault]]
    """All of them, where there may be several"""
    bound: NotRequired[int]
    """How many of something there may be"""


@with_config(OPEN)
class SceneEditEvidence(TypedDict):
    """Which operation cannot be applied, and what is in its way."""

    operation: NotRequired[int]
    """Which one, from 0"""
    name: NotRequired[str]
    """Of what it is about"""
    known: NotRequired[list[str]]
    """Names that there are already"""
    movable: NotRequired[list[str]]
    """What may be moved"""
    attached: NotRequired[list[str]]
    """What is attached"""
    frame: NotRequired[str]
    """That it is attached to, or would be"""
    pair: NotRequired[list[str]]
    """Of bodies that is not allowed to collide"""
    allowed: NotRequired[list[list[str]]]
    """Pairs that are allowed to collide"""
    hangs_on: NotRequired[str]
    """What the frame belongs to"""


@with_config(OPEN)
class AssetEvidence(TypedDict):
    """Which file does not exist."""

    uri: str
    """As the scene or the model has it"""
    known: NotRequired[list[str]]
    """What there is instead"""
    path: NotRequired[str]
    """Its place in the scene"""


@with_config(OPEN)
class ModelEvidence(TypedDict):
    """What is wrong with a robot, or with one of its files."""

    reason: str
    """What is wrong"""
    file: NotRequired[str]
    """In which file"""
    element: NotRequired[str]
    """In which element of it"""
    joint: NotRequired[str]
    """At which joint"""
    joints: NotRequired[list[str]]
    """At which joints"""
    body: NotRequired[str]
    """At which body"""
    link: NotRequired[str]
    """At which link"""
    elements: NotRequired[object]
    """Which elements of it have the fault"""
    robot: NotRequired[str]
    """Which robot of the scene it is"""


@with_config(OPEN)
class ProblemFieldEvidence(TypedDict):
    """Which field of a request is wrong; other members say what is in its way."""

    field: str
    """Its place in the request, as names and numbers with dots"""


@with_config(OPEN)
class NameEvidence(TypedDict):
    """A name that does not exist."""

    kind: str
    """What was looked for"""
    name: str
    """As it was given"""
    known: list[str]
    """Names that there are"""
    nearest: NotRequired[list[str]]
    """Of these, those that were perhaps meant, the nearest first"""
    operation: NotRequired[int]
    """Of an edit, in which operation, from 0"""


@with_config(OPEN)
class FaultsEvidence(TypedDict):
    """Where a body or its parameters have faults."""

    faults: list[DocumentFault]
    """At most 20 of them"""


@with_config(OPEN)
class CountEvidence(TypedDict):
    """How many values a list should have."""

    field: NotRequired[str]
    """Its place in the request"""
    expected: int
    """As many"""
    got: int
    """As many were given"""
    names: list[str]
    """Of the coordinates that they are for"""
