"""The OpenAPI document: FastAPI's, with what FastAPI cannot know."""

from collections.abc import Callable
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi

from planning.world.documents.scene_document import SceneDocument
from service.api.document.links import declare_links
from service.api.failures.problem import Problem

_REF = "#/components/schemas/{model}"
_TAGS = [
    {"name": "models", "description": "Robots there are"},
    {"name": "scenes", "description": "Robots and their surroundings"},
    {"name": "queries", "description": "Questions to a scene, answered at once"},
    {"name": "planners", "description": "OMPL's planners"},
    {"name": "plans", "description": "Certified motions, made by durable jobs"},
    {"name": "batches", "description": "Many plans in one request"},
    {"name": "regions", "description": "Convex regions of free configurations, for GCS"},
    {"name": "trajectories", "description": "Paths and motions of your own, timed and proven"},
    {"name": "executions", "description": "Motions that are being carried out"},
    {"name": "webhooks", "description": "Addresses that are told what happens to jobs"},
    {"name": "operations", "description": "The server itself"},
]


def install(app: FastAPI, add: Callable[[dict[str, Any]], None]) -> None:
    """Make `app` serve the full document.

    Args:
        app: What it is of.
        add: Adds to the document what stands around all routes, which they do not know of.
    """

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            app.openapi_schema = _document(app, add)
        return app.openapi_schema

    app.openapi = openapi


def _document(app: FastAPI, add: Callable[[dict[str, Any]], None]) -> dict[str, Any]:
    document = get_openapi(
        title=app.title,
        version=app.version,
        description=app.description,
        routes=app.routes,
        tags=_TAGS,
        separate_input_output_schemas=False,
    )
    schemas: dict[str, Any] = document["components"]["schemas"]
    for model in (Problem, SceneDocument):
        schema = model.model_json_schema(ref_template=_REF)
        for name, part in schema.pop("$defs", {}).items():
            schemas.setdefault(name, part)
        schemas[model.__name__] = schema
    _declare_events(document)
    add(document)
    declare_links(document)
    inlined: dict[str, Any] = _inlined(document, schemas)
    return inlined


def _declare_events(document: dict[str, Any]) -> None:
    """Leave out what FastAPI adds to streams: `itemSchema` is of OpenAPI 3.2, the rest of 3.1."""
    for operations in document["paths"].values():
        for operation in operations.values():
            for answer in operation["responses"].values():
                answer.get("content", {}).get("text/event-stream", {}).pop("itemSchema", None)


def _inlined(part: Any, schemas: dict[str, Any]) -> Any:
    """Return the document with names for types only: bounded numbers and lists are spelled out."""
    if isinstance(part, list):
        return [_inlined(child, schemas) for child in part]
    if not isinstance(part, dict):
        return part
    name = str(part.get("$ref", "")).split("/")[-1]
    if name in schemas and not _is_type(schemas[name]):
        rest = {key: child for key, child in part.items() if key != "$ref"}
        return _inlined({**schemas[name], **rest}, schemas)
    return {
        key: _inlined(child, schemas)
        for key, child in part.items()
        if not (child in schemas.values() and key in schemas and not _is_type(child))
        # what goes without saying; where it is said, types in TypeScript have every name
        and not (key == "additionalProperties" and child is True and "properties" in part)
    }


def _is_type(schema: dict[str, Any]) -> bool:
    return bool({"properties", "enum", "oneOf"} & set(schema)) or schema.get("type") == "object"
