"""Names in requests: by its type a field says what it names, and `mentions` finds all of them.

What a name must be one of, the resource that is asked knows: `service/scenes/validation.py` for the
parts of scenes.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from types import UnionType
from typing import Annotated, Any, TypeAliasType, Union, get_args, get_origin

from pydantic import BaseModel

from planning.errors import SceneInvalid, UnknownName
from planning.world.documents.document_faults import Fault
from service.api.models import COORDINATES, Mark

type Steps = tuple[str | int, ...]


@dataclass(frozen=True)
class Mention:
    """A marked value in a request.

    Attributes:
        steps: Keys and indices that lead to it.
        kind: Of its mark.
        value: A name, or a list of numbers.
    """

    steps: Steps
    kind: str
    value: Any

    @property
    def path(self) -> str:
        """Where it stands, as `goal.poses.0.frame`."""
        return Fault(self.steps, "", "").path

    @property
    def pointer(self) -> str:
        """Where it stands, as a JSON pointer."""
        return Fault(self.steps, "", "").pointer

    def error(self, nearest: Sequence[str]) -> dict[str, Any]:
        """Return what a problem document says of a name that does not exist."""
        message = f"{self.kind} {self.value!r} does not exist"
        return {"pointer": self.pointer, "message": message, "nearest": list(nearest)}


def mentions(request: object) -> Iterator[Mention]:
    """Yield all marked values of a request, in its order."""
    finder = _finder(type(request))
    return iter(()) if finder is None else finder(request, ())


def located(fault: UnknownName, document: Any, within: Steps = ()) -> UnknownName:
    """Return an error with `errors` that say where a document says the name that does not exist.

    Args:
        fault: Of a name that is looked up where nothing is known of the request.
        document: The request, or a part of it.
        within: Keys and indices that lead to the part.
    """
    name, kind = fault.evidence.get("name", ""), fault.evidence.get("kind", "")
    steps = _place_of(name, document, within) or within
    if not steps:
        return fault
    error = Mention(steps, kind, name).error(fault.evidence.get("nearest", []))
    return UnknownName(fault.detail, {**fault.evidence, "errors": [error]})


def located_in_scene(fault: SceneInvalid, document: Any) -> SceneInvalid:
    """Return an error with `errors` that say where a scene names what does not exist.

    Args:
        fault: Of a scene; its `path` has the keys and indices that lead to the name.
        document: The scene.
    """
    evidence = fault.evidence
    if "nearest" not in evidence or "errors" in evidence:
        return fault
    steps = tuple(int(s) if s.isdigit() else s for s in str(evidence.get("path", "")).split("."))
    part: Any = document
    for step in steps:
        if not (isinstance(part, list | dict) and step in _steps(part)):
            return fault
        inner: Any = part
        part = inner[step]
    error = Mention(steps, evidence["kind"], evidence["name"]).error(evidence["nearest"])
    return SceneInvalid(fault.detail, {**evidence, "errors": [error]})


def _steps(document: Any) -> Iterable[str | int]:
    return range(len(document)) if isinstance(document, list) else document


def _place_of(name: str, document: Any, steps: Steps) -> Steps | None:
    """Return where a document first says a name, as a value or as a key; None if nowhere.

    What is called so itself, under the key `name`, does not mention it.
    """
    children: Iterator[tuple[str | int, Any]] = iter(())
    if isinstance(document, Mapping):
        children = iter(document.items())
    elif isinstance(document, list):
        children = enumerate(document)
    for step, child in children:
        here = (*steps, step)
        if step == name or (child == name and step != "name"):
            return here
        if (found := _place_of(name, child, here)) is not None:
            return found
    return None


type _Finder = Callable[[Any, Steps], Iterator[Mention]]


def _finder(annotation: Any) -> _Finder | None:
    """Return what finds the marked values in values of a type; None if there can be none."""
    if isinstance(annotation, TypeAliasType):
        return _finder(annotation.__value__)
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return _model(annotation)
    args = get_args(annotation)
    match get_origin(annotation):
        case origin if origin is Annotated:
            return _annotated(args[0], args[1:])
        case origin if origin in {Union, UnionType}:
            return _union([_finder(arg) for arg in args])
        case origin if origin in {list, dict}:
            return _items(*map(_finder, args))
        case _:
            return None


def _annotated(annotation: Any, metadata: tuple[Any, ...]) -> _Finder | None:
    for mark in metadata:
        if isinstance(mark, Mark):
            return _leaf(mark)
    return _finder(annotation)


def _leaf(mark: Mark) -> _Finder:
    is_list = mark.kind == COORDINATES

    def find(value: Any, steps: Steps) -> Iterator[Mention]:
        is_row = isinstance(value, list) and not any(isinstance(x, list) for x in value[:1])
        if is_row if is_list else isinstance(value, str):
            yield Mention(steps, mark.kind, value)

    return find


def _union(finders: list[_Finder | None]) -> _Finder | None:
    chosen = [finder for finder in finders if finder is not None]

    def find(value: Any, steps: Steps) -> Iterator[Mention]:
        for finder in chosen:  # those of other types find nothing
            yield from finder(value, steps)

    return find if chosen else None


def _items(*finders: _Finder | None) -> _Finder | None:
    """Return what finds marked items of lists, or marked keys and items of objects."""
    of_key = finders[0] if len(finders) == 2 else None
    of_item = finders[-1]

    def find(value: Any, steps: Steps) -> Iterator[Mention]:
        if not isinstance(value, dict | list):
            return
        for step, item in value.items() if isinstance(value, dict) else enumerate(value):
            if of_key is not None:
                yield from of_key(step, (*steps, step))
            if of_item is not None:
                yield from of_item(item, (*steps, step))

    return None if of_key is None and of_item is None else find


@cache
def _model(kind: type[BaseModel]) -> _Finder | None:
    finders = {
        name: finder
        for name, field in kind.model_fields.items()
        if (finder := _annotated(field.annotation, tuple(field.metadata))) is not None
    }

    def find(value: Any, steps: Steps) -> Iterator[Mention]:
        for name, finder in finders.items() if isinstance(value, kind) else ():
            yield from finder(getattr(value, name), (*steps, name))

    return find if finders else None
