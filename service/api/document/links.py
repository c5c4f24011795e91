"""Links of the OpenAPI document: what can be asked next about what has just been made.

They are found, not listed: what `GET /v1/plans/{plan}` shows is a plan, so whatever makes one leads
to every operation that has `{plan}` in its path (OpenAPI 3.1, 4.8.20).
"""

import re
from collections.abc import Iterator
from typing import Any

# Made at once, accepted, and accepted and ended within the time that was waited.
_MADE = ("200", "201", "202")
_PARAMETER = re.compile(r"\{(\w+)\}")


def declare_links(document: dict[str, Any]) -> None:
    """Add links to every answer that has a new resource."""
    operations = list(_operations(document))
    shown = {
        model: _PARAMETER.findall(path)[-1]
        for method, path, operation in operations
        if method == "get" and path.endswith("}") and (model := _model(operation, "200"))
    }
    for _, _, operation in operations:
        if not {"201", "202"} & set(operation["responses"]):
            continue
        for status in _MADE:
            model = _model(operation, status)  # what is told once, such as a secret, is in `New...`
            parameter = shown.get(model) or shown.get(model.removeprefix("New"))
            if parameter is not None:
                operation["responses"][status]["links"] = _links(parameter, operations)


def _links(parameter: str, operations: list[tuple[str, str, dict[str, Any]]]) -> dict[str, Any]:
    """Return a link to each operation that needs this parameter of its path and no other."""
    return {
        operation["operationId"]: {
            "operationId": operation["operationId"],
            "parameters": {parameter: "$response.body#/id"},
        }
        for _, path, operation in operations
        if _PARAMETER.findall(path) == [parameter]
    }


def _model(operation: dict[str, Any], status: str) -> str:
    """Return the name of the schema that is answered with a status, or an empty text."""
    content = operation["responses"].get(status, {}).get("content", {})
    schema: dict[str, str] = content.get("application/json", {}).get("schema", {})
    return schema.get("$ref", "").rpartition("/")[2]


def _operations(document: dict[str, Any]) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Yield method, path and description of every operation."""
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            yield method, path, operation
