"""Query parameters that are not declared are refused, and those that come twice."""

from fastapi import Request
from fastapi.dependencies.models import Dependant
from fastapi.routing import APIRoute

from planning.errors import UnknownName
from service.errors import RequestInvalid


async def require_known_query(request: Request) -> None:
    """Go on only if the endpoint, or what it depends on, declares every parameter of the query.

    Raises:
        UnknownName: It does not.
        RequestInvalid: A parameter is given twice.
    """
    route = request.scope["route"]
    known = _declared(route.dependant) if isinstance(route, APIRoute) else set[str]()
    for name in request.query_params:
        if name not in known:
            raise UnknownName.among("query parameter", name[:80], known)
        if len(request.query_params.getlist(name)) > 1:
            message = f"query.{name}: it is given twice"
            fault = {"path": f"query.{name}", "pointer": "", "message": message}
            raise RequestInvalid(message, {"faults": [{**fault, "type": "repeated_key"}]})


def _declared(dependant: Dependant) -> set[str]:
    own = {field.alias for field in dependant.query_params}
    return own.union(*(_declared(further) for further in dependant.dependencies))
