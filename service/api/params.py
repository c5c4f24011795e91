"""Parameters that several endpoints take, and a check that a query has no others.

What models of queries would do instead, and cost: docs/decisions/0086.
"""

from collections.abc import Collection
from typing import Annotated

from fastapi import Header, Path, Query, Request
from fastapi.dependencies.models import Dependant

from planning.errors import UnknownName
from service.errors import RequestInvalid

type SceneId = Annotated[str, Path(max_length=128, description="Id of a scene")]
type Revision = Annotated[
    int | None,
    Query(ge=1, le=2**31 - 1, description="Revision of the scene; by default the latest"),
]
type PlanId = Annotated[str, Path(max_length=128, description="Id of a plan")]
type ExecutionId = Annotated[str, Path(max_length=128, description="Id of an execution")]
type RegionsId = Annotated[str, Path(max_length=128, description="Id of regions")]
type LastEventId = Annotated[
    str | None,
    Header(
        alias="Last-Event-ID",
        max_length=40,
        description="Id of the last event that was seen; those after it are sent",
    ),
]


def declared_query(dependant: Dependant) -> frozenset[str]:
    """Return the parameters of the query that an endpoint, or what it depends on, declares."""
    own = {field.alias for field in dependant.query_params}
    return frozenset(own).union(*(declared_query(further) for further in dependant.dependencies))


def require_known_query(request: Request, known: Collection[str]) -> None:
    """Go on only if a query has none but known parameters, and none of them twice.

    Raises:
        UnknownName: It has another one.
        RequestInvalid: A parameter is given twice.
    """
    for name in request.query_params:
        if name not in known:
            raise with_parameter(name, UnknownName.among("query parameter", name[:80], known))
        if len(request.query_params.getlist(name)) > 1:
            message = f"query.{name}: it is given twice"
            fault = {"path": f"query.{name}", "pointer": "", "parameter": name}
            fault |= {"message": "it is given twice", "type": "repeated_key"}
            raise RequestInvalid(message, {"faults": [fault]})


def with_parameter(name: str, fault: UnknownName) -> UnknownName:
    """Return an error with `errors` that say which parameter has a name that does not exist."""
    evidence, shown = fault.evidence, name[:80]
    message = f"query.{shown}: {evidence['kind']} {evidence['name']!r} does not exist"
    error = {"pointer": "", "parameter": shown, "message": message, "nearest": evidence["nearest"]}
    return UnknownName(fault.detail, {**evidence, "errors": [error]})


def located_in_query(fault: UnknownName, request: Request) -> UnknownName:
    """Return an error that says which parameter of a query says the name, if one does."""
    for name, text in request.query_params.items():
        if fault.evidence.get("name") in text.split(","):
            return with_parameter(name, fault)
    return fault
