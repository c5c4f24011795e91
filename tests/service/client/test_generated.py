"""Both clients have every operation of the document, as the document has it."""

import asyncio
import inspect
import json
from urllib.parse import quote

import httpx
import pytest
from pydantic import BaseModel

from client.generator.__main__ import DOCUMENT, differing
from client.generator.annotations import snake
from client.generator.document import Document
from tests.profiles import only_campaign
from wayproof_client import AsyncClient, Client, models

SAID = Document.of(DOCUMENT)
OPERATIONS = [pytest.param(one, id=one.id) for one in SAID.operations]


class Sent(Exception):
    """A request that was about to leave."""

    def __init__(self, request):
        super().__init__(str(request.url))
        self.request = request


def refuse(request):
    raise Sent(request)


async def refuse_later(request):
    raise Sent(request)


def sample(parameter):
    """A value that the schema of a parameter allows."""
    schema = parameter["schema"]
    kinds = [schema, *schema.get("anyOf", ())]
    if any(kind.get("type") in {"number", "integer"} for kind in kinds):
        return 7
    if any(kind.get("type") == "boolean" for kind in kinds):
        return True
    return next((kind["enum"][-1] for kind in kinds if "enum" in kind), "a/b c")


def arguments_of(method, operation):
    """Every argument that a method takes, by the names of the document."""
    known = {snake(one["name"]): sample(one) for one in operation.parameters}
    known |= {"body": {"n": 1}, "media_type": "application/json"}
    taken = list(inspect.signature(method).parameters)
    assert set(taken) <= set(known)
    return {name: known[name] for name in taken}


def sent_by(client, name, operation):
    """The request that a method would send, and the arguments it was given."""
    method = getattr(client, name)
    given = arguments_of(method, operation)

    async def awaited():
        answer = method(**given)
        return await (anext(answer) if inspect.isasyncgen(answer) else answer)

    def called():
        answer = method(**given)
        return next(answer)

    with pytest.raises(Sent) as stopped:
        asyncio.run(awaited()) if isinstance(client, AsyncClient) else called()
    return stopped.value.request, given


def clients():
    return (
        Client("http://localhost", transport=httpx.MockTransport(refuse)),
        AsyncClient("http://localhost", transport=httpx.MockTransport(refuse_later)),
    )


@pytest.mark.parametrize("kind", [0, 1], ids=["sync", "async"])
@pytest.mark.parametrize("operation", OPERATIONS)
def test_every_operation_sends_all_that_the_document_says(operation, kind):
    client, name = clients()[kind], snake(operation.id)
    names = [name, f"{name}_as"] if hasattr(client, f"{name}_as") else [name]
    seen = set()
    for one in names:
        request, given = sent_by(client, one, operation)
        assert request.method == operation.method
        path = operation.path
        for parameter, value in given.items():
            path = path.replace(f"{{{parameter}}}", quote(str(value), safe=""))
        assert request.url.raw_path.decode().split("?")[0] == path
        for parameter in operation.parameters:
            if snake(parameter["name"]) not in given:
                continue
            seen.add(parameter["name"])
            wanted = given[snake(parameter["name"])]
            as_text = str(wanted).lower() if isinstance(wanted, bool) else str(wanted)
            if parameter["in"] == "query":
                assert request.url.params[parameter["name"]] == as_text
            if parameter["in"] == "header":
                assert request.headers[parameter["name"]] == as_text
        if operation.bodies:
            assert json.loads(request.content) == {"n": 1}
            assert request.headers["content-type"] in operation.bodies
        else:
            assert request.content == b""
    assert seen == {one["name"] for one in operation.parameters}


def test_both_clients_have_the_same_methods():
    sync, later = (
        {name for name, _ in inspect.getmembers(kind, callable) if not name.startswith("_")}
        for kind in (Client, AsyncClient)
    )
    assert sync - later == {"ask_raw_events"}
    assert later <= sync
    assert {snake(one.id) for one in SAID.operations} <= sync


def test_generated_modules_are_as_the_document_has_them():
    assert differing(SAID) == [], "run: python -m client.generator"


def test_a_new_operation_makes_a_difference():
    text = json.loads(DOCUMENT.read_text())
    text["paths"]["/v1/news"] = {
        "get": {**text["paths"]["/healthz"]["get"], "operationId": "getNews"}
    }
    found = differing(Document.from_json(text))
    assert found == ["operations.py", "async_operations.py"]


@only_campaign("builds some hundred schemas: 5 s")
def test_every_kind_of_answer_has_a_schema_that_can_be_built():
    kinds = [
        one for one in vars(models).values() if inspect.isclass(one) and issubclass(one, BaseModel)
    ]
    assert len(kinds) > 200
    for kind in kinds:
        assert kind.model_rebuild() is not False
        kind.model_json_schema()
