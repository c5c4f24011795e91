"""The routes of the service without an application around them: listed in no time."""

from functools import cache

from fastapi.dependencies.models import Dependant
from fastapi.routing import APIRoute

from service.app import PARTS


@cache
def api_routes() -> tuple[APIRoute, ...]:
    """Return every route that the OpenAPI document describes."""
    return tuple(
        route
        for part in PARTS
        for route in part.router.routes
        if isinstance(route, APIRoute) and route.include_in_schema
    )


def takes_data(route: APIRoute) -> bool:
    """Return whether a request says more than a method and a fixed path."""
    declared_by_hand = "requestBody" in (route.openapi_extra or {})
    has_body = declared_by_hand or route.body_field is not None
    return has_body or _has_parameters(route.dependant)


def _has_parameters(dependant: Dependant) -> bool:
    own = (dependant.path_params, dependant.query_params, dependant.header_params)
    return any(own) or any(_has_parameters(further) for further in dependant.dependencies)
