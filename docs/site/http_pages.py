"""Pages of the HTTP interface, from the committed OpenAPI document."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from docs.site.schema_tables import SchemaTables, cell

_METHODS = ("get", "post", "put", "patch", "delete")
_EVENTS = ("JobEvent", "ExecutionEvent", "StateEvent", "WebhookEvent")


def http_pages(document: Path) -> Iterator[tuple[str, str]]:
    """Yield path and text of the pages that a document gives."""
    api = json.loads(document.read_text(encoding="utf-8"))
    schemas = api["components"]["schemas"]
    yield "reference/http.md", _operations(api)
    yield "reference/plan-request.md", _options(schemas)
    yield "reference/events.md", _events(schemas)


def _operations(api: Mapping[str, Any]) -> str:
    parts = ["# HTTP", api["info"]["description"]]
    parts.append(
        "The whole document is at `/openapi.json` of a server; [its promises](api-policy.md) and"
        " [the errors](errors/index.md) have pages of their own. A plan's request is described"
        " [field by field](plan-request.md)."
    )
    for tag in api["tags"]:
        parts += [f"## {tag['name']}", f"{tag['description']}."]
        for path, item in api["paths"].items():
            for method in _METHODS:
                if tag["name"] in item.get(method, {}).get("tags", ()):
                    parts.append(_operation(method, path, item[method]))
    return "\n\n".join(parts) + "\n"


def _operation(method: str, path: str, operation: Mapping[str, Any]) -> str:
    parts = [f"### `{method.upper()} {path}`", operation.get("description", operation["summary"])]
    rows = [
        f"| `{each['name']}` | {each['in']} | {cell(each.get('description', ''))} |"
        for each in operation.get("parameters", ())
    ]
    if rows:
        parts.append("\n".join(["| parameter | in | meaning |", "|---|---|---|", *rows]))
    body = _models(operation.get("requestBody", {}))
    if body:
        parts.append(f"Body: {body}.")
    answers = [
        f"| {status} | {_models(answer)} | {answer['description'].splitlines()[0]} |"
        for status, answer in operation["responses"].items()
    ]
    parts.append("\n".join(["| status | answer | |", "|---|---|---|", *answers]))
    return "\n\n".join(parts)


def _models(content: Mapping[str, Any]) -> str:
    found = []
    for media, each in content.get("content", {}).items():
        name = each.get("schema", {}).get("$ref", "").rpartition("/")[2]
        found.append(f"`{name}` ({media})" if name else media)
    return ", ".join(found)


def _options(schemas: Mapping[str, Any]) -> str:
    head = (
        "# The request of a plan\n\nWhat `POST /v1/plans` takes, in full; only `scene`, `group` and"
        " `goal` are needed. Pages that explain: [goals](../how-to/plan/goals.md),"
        " [search](../how-to/plan/search.md), [constraints](../how-to/plan/constraints.md),"
        " [optimise](../how-to/plan/optimise.md), [timing](../how-to/plan/timing.md).\n\n"
    )
    return head + SchemaTables(schemas).section("PlanRequest") + "\n"


def _events(schemas: Mapping[str, Any]) -> str:
    head = (
        "# Events\n\nStreams are server-sent events; `Last-Event-ID` goes on where a stream broke"
        " off. What is in `data` is JSON."
    )
    tables = SchemaTables(schemas)
    return "\n\n".join([head, *map(tables.section, _EVENTS)]) + "\n"
