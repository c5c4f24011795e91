"""Document faults: pydantic's validation errors as messages for the document's author.

Pydantic's locations have steps of its own (branches of unions), and its message for a missing
field does not name misspelt candidates.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from planning.errors import UnknownName

type Step = str | int
type Schema = Mapping[str, Any]

_UNKNOWN_FIELD, _MISSING_FIELD = "extra_forbidden", "missing"
_UNKNOWN_VALUES, _UNKNOWN_TAG = ("literal_error", "enum"), "union_tag_invalid"
# Pydantic names the right values in a sentence only: "'toppra', 'linear' or 'jerk'".
_QUOTED = re.compile("'([^']+)'")
_MAX_MESSAGE_LENGTH = 500
# Depth of nested unions: `positions` by joint, each a number or several.
_MAX_UNION_DEPTH = 4
# Number of faults with suggested names: a search for names takes a tenth of a millisecond each.
_MAX_EXPLAINED = 1000


@dataclass(frozen=True)
class Fault:
    """Fault of one part of a document.

    Attributes:
        steps: Keys and indices from the root to the part.
        message: The fault, for people.
        type: Pydantic's name for the kind of fault.
        nearest: Names of fields, or values, similar to the wrong one.
    """

    steps: tuple[Step, ...]
    message: str
    type: str
    nearest: tuple[str, ...] = ()

    @property
    def path(self) -> str:
        """The steps joined by dots, as scene files name parts."""
        return ".".join(str(step)[:80] for step in self.steps)

    @property
    def pointer(self) -> str:
        """The steps as a JSON pointer (RFC 6901)."""
        steps = (str(step)[:200].replace("~", "~0").replace("/", "~1") for step in self.steps)
        return "".join(f"/{step}" for step in steps)


def faults_of(errors: Sequence[Mapping[str, Any]], document: Any, schema: Schema) -> list[Fault]:
    """Return the faults of a document, without those of unlikely union branches.

    Args:
        errors: Pydantic's list of errors; their locations begin at the document's root.
        document: The validated document.
        schema: JSON schema of its model.
    """
    for depth in range(_MAX_UNION_DEPTH):
        errors = _errors_of_likely_branches(errors, document, depth)
    first = [_fault(one, document, schema) for one in errors[:_MAX_EXPLAINED]]
    rest = [
        Fault(_real_steps(one, document), _message_of(one), one["type"])
        for one in errors[_MAX_EXPLAINED:]
    ]
    return [_with_misspelling(fault, first) for fault in first] + rest


def _with_misspelling(fault: Fault, faults: Sequence[Fault]) -> Fault:
    """Return the fault of a missing field with the misspelt field that was likely meant."""
    if fault.type != _MISSING_FIELD:
        return fault
    for other in faults:
        is_sibling = other.steps[:-1] == fault.steps[:-1]
        if is_sibling and other.nearest[:1] == fault.steps[-1:]:
            return replace(fault, message=f"{fault.message}: {other.message}"[:_MAX_MESSAGE_LENGTH])
    return fault


def _fault(error: Mapping[str, Any], document: Any, schema: Schema) -> Fault:
    steps = _real_steps(error, document)
    if error["type"] == _UNKNOWN_FIELD and steps:
        known = fields_at(schema, document, steps[:-1])
        unknown = UnknownName.among("field", str(steps[-1])[:80], known)
        nearest = tuple(unknown.evidence["nearest"])
        return Fault(steps, unknown.detail[:_MAX_MESSAGE_LENGTH], error["type"], nearest)
    return value_fault(steps, error)


def value_fault(steps: tuple[Step, ...], error: Mapping[str, Any]) -> Fault:
    """Return the fault of a value that is there, with the known values it resembles.

    The place of an unknown tag is the tag's, not that of the object which it selects.

    Args:
        steps: Keys and indices from the root to the value.
        error: One of pydantic's errors, with its context.
    """
    kind, context = str(error["type"]), error.get("ctx", {})
    wrong, known = error.get("input"), context.get("expected", "")
    if kind == _UNKNOWN_TAG:
        wrong, known = context["tag"], context["expected_tags"]
        # The name of a function, without quotes, where the tag is no field.
        steps = (*steps, *_QUOTED.findall(context["discriminator"]))
    elif kind not in _UNKNOWN_VALUES or not isinstance(wrong, str):
        return Fault(steps, _message_of(error), kind)
    nearest = UnknownName.among("value", wrong[:80], _QUOTED.findall(known)).evidence["nearest"]
    hint = f"; did you mean {nearest[0]!r}?" if nearest else ""
    return Fault(steps, f"{_message_of(error)}{hint}"[:_MAX_MESSAGE_LENGTH], kind, tuple(nearest))


def _message_of(error: Mapping[str, Any]) -> str:
    """Return the message of one of pydantic's errors."""
    return str(error["msg"]).removeprefix("Value error, ")[:_MAX_MESSAGE_LENGTH]


def _errors_of_likely_branches(
    errors: Sequence[Mapping[str, Any]], document: Any, depth: int
) -> list[Mapping[str, Any]]:
    """Return the faults of the most likely branch of each union inside `depth` others.

    The likely branch has the document's type of value, and among those the fewest faults.
    """
    branches: dict[tuple[Step, ...], list[Mapping[str, Any]]] = {}
    error_branches = [_union_branch(one, document, depth) for one in errors]
    for one, fork in zip(errors, error_branches, strict=True):
        if fork is not None:
            branches.setdefault(fork, []).append(one)
    best: dict[tuple[Step, ...], tuple[Step, ...]] = {}
    for fork in branches:
        union = fork[:-1]
        best[union] = min(
            best.get(union, fork), fork, key=lambda at: _branch_rank(at, branches[at])
        )
    pairs = zip(errors, error_branches, strict=True)
    return [one for one, fork in pairs if fork is None or best[fork[:-1]] == fork]


def _branch_rank(branch: tuple[Step, ...], faults: Sequence[Mapping[str, Any]]) -> tuple[bool, int]:
    is_of_another_kind = any(
        len(one["loc"]) == len(branch) and str(one["type"]).endswith("_type") for one in faults
    )
    return is_of_another_kind, len(faults)


def _union_branch(error: Mapping[str, Any], document: Any, depth: int) -> tuple[Step, ...] | None:
    """Return the location of a union branch, inside `depth` others; None where there is none."""
    location, remaining_depth = error["loc"], depth
    for i, step in enumerate(location):
        if _has(document, step):
            document = document[step]
        elif not _is_field(error, i):
            if remaining_depth == 0:
                return tuple(location[: i + 1])
            remaining_depth -= 1
    return None


def _is_field(error: Mapping[str, Any], i: int) -> bool:
    """Return whether a step that the document does not have is a field, not a branch."""
    is_last = i == len(error["loc"]) - 1
    return is_last and error["type"] in (_UNKNOWN_FIELD, _MISSING_FIELD)


def _has(document: Any, step: Step) -> bool:
    if isinstance(document, Mapping):
        return step in document
    return isinstance(document, list) and isinstance(step, int) and 0 <= step < len(document)


def _real_steps(error: Mapping[str, Any], document: Any) -> tuple[Step, ...]:
    """Return the location of a fault without pydantic's artificial steps."""
    real: list[Step] = []
    for i, step in enumerate(error["loc"]):
        if _has(document, step):
            document = document[step]
            real.append(step)
        elif _is_field(error, i):
            real.append(step)
    return tuple(real)


def fields_at(schema: Schema, document: Any, steps: Sequence[Step]) -> list[str]:
    """Return the fields that a part of a document may have, by the JSON schema of the whole."""
    schemas = list(_matching_schemas(schema, document, schema))
    for step in steps:
        document = document[step] if _has(document, step) else None
        below = [child for part in schemas for child in _child_schemas(part, step)]
        schemas = [one for child in below for one in _matching_schemas(child, document, schema)]
    return sorted({name for part in schemas for name in part.get("properties", {})})


def _child_schemas(part: Schema, step: Step) -> Iterator[Schema]:
    inner = part.get("items") if isinstance(step, int) else None
    if inner is None and isinstance(step, str):
        inner = part.get("properties", {}).get(step, part.get("additionalProperties"))
    if isinstance(inner, Mapping):
        yield inner


def _matching_schemas(part: Schema, document: Any, root: Schema) -> Iterator[Schema]:
    """Yield the schemas of a union that a document can match, by their required constants."""
    if "$ref" in part:
        name = str(part["$ref"]).rsplit("/", 1)[-1]
        yield from _matching_schemas(root["$defs"][name], document, root)
        return
    unions = [branch for kind in ("anyOf", "oneOf", "allOf") for branch in part.get(kind, [])]
    for branch in unions:
        yield from _matching_schemas(branch, document, root)
    if not unions and not _contradicts_constants(part, document):
        yield part


def _contradicts_constants(part: Schema, document: Any) -> bool:
    properties = part.get("properties", {})
    return isinstance(document, Mapping) and any(
        "const" in field and name in document and document[name] != field["const"]
        for name, field in properties.items()
    )
