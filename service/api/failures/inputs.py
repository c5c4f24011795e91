"""Evidence of requests whose content has a fault: scenes, models, names, numbers."""

from typing import NotRequired, TypedDict

from pydantic import with_config

from service.api.document.known_values import NameKind
from service.api.failures.parts import OPEN


@with_config(OPEN)
class DocumentFault(TypedDict):
    """One fault of a document or of a parameter."""

    path: str
    """Place of the fault, as names and numbers with dots"""
    pointer: str
    """Place of the fault as a JSON pointer (RFC 6901); empty for the root and for parameters"""
    parameter: NotRequired[str]
    """Name of the parameter of the query, the path or the headers; absent for the body"""
    message: str
    """What is wrong there, for a person"""
    nearest: NotRequired[list[str]]
    """Names or values that were perhaps meant, the nearest first"""
    line: NotRequired[int | None]
    """Line in the text, from 1; null where it is not known"""
    type: NotRequired[str]
    """Kind of the fault, as the library calls it that checks documents"""


@with_config(OPEN)
class SceneFaultEvidence(TypedDict):
    """Place of a fault in a scene document."""

    path: NotRequired[str]
    """Place of the fault, as names and numbers with dots; empty for the root"""
    pointer: NotRequired[str]
    """Place of the fault as a JSON pointer"""
    line: NotRequired[int | None]
    """Line in the text, from 1; null where it is not known"""
    faults: NotRequired[list[DocumentFault]]
    """All of them, where there may be several"""
    bound: NotRequired[int]
    """Largest number that is allowed"""


@with_config(OPEN)
class SceneEditEvidence(TypedDict):
    """Operation that cannot be applied, and what is in its way."""

    operation: NotRequired[int]
    """Index of the operation, from 0"""
    name: NotRequired[str]
    """Name that the operation is about"""
    known: NotRequired[list[str]]
    """Names that exist already"""
    movable: NotRequired[list[str]]
    """Names of what may be moved"""
    attached: NotRequired[list[str]]
    """Names of what is attached"""
    frame: NotRequired[str]
    """Frame that the object is attached to, or would be"""
    pair: NotRequired[list[str]]
    """Two bodies that are not allowed to collide"""
    allowed: NotRequired[list[list[str]]]
    """Pairs that are allowed to collide"""
    hangs_on: NotRequired[str]
    """Parent of the frame"""


@with_config(OPEN)
class AssetEvidence(TypedDict):
    """File that does not exist."""

    uri: str
    """Name of the file in the scene or in the model"""
    known: NotRequired[list[str]]
    """Names that exist"""
    path: NotRequired[str]
    """Place of the name in the scene"""


@with_config(OPEN)
class ModelEvidence(TypedDict):
    """Fault of a robot, or of one of its files."""

    reason: str
    """What is wrong"""
    file: NotRequired[str]
    """File with the fault"""
    element: NotRequired[str]
    """Element of the file with the fault"""
    joint: NotRequired[str]
    """Joint with the fault"""
    joints: NotRequired[list[str]]
    """Joints with the fault"""
    body: NotRequired[str]
    """Body with the fault"""
    link: NotRequired[str]
    """Link with the fault"""
    elements: NotRequired[object]
    """Elements of the file with the fault"""
    robot: NotRequired[str]
    """Robot of the scene that has the fault"""


@with_config(OPEN)
class ProblemFieldEvidence(TypedDict):
    """Field of a request that is wrong; other members say what is in its way."""

    field: str
    """Place of the field in the request, as names and numbers with dots"""


@with_config(OPEN)
class NameEvidence(TypedDict):
    """A name that does not exist."""

    kind: NameKind
    """Kind of the name, such as `frame`"""
    name: str
    """Name that was given"""
    known: list[str]
    """Names that exist"""
    nearest: NotRequired[list[str]]
    """Known names that were perhaps meant, the nearest first"""
    operation: NotRequired[int]
    """Index of the operation of an edit, from 0"""


@with_config(OPEN)
class FaultsEvidence(TypedDict):
    """Faults of a body or of its parameters."""

    faults: list[DocumentFault]
    """Faults, at most 20 of them"""


@with_config(OPEN)
class CountEvidence(TypedDict):
    """Number of values that a list should have."""

    field: NotRequired[str]
    """Place of the list in the request"""
    expected: int
    """Number of values that are expected"""
    got: int
    """Number of values that were given"""
    names: list[str]
    """Names of the coordinates that the values are for"""
