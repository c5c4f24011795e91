"""The OpenAPI document is complete enough to generate a pleasant client from."""

from openapi_spec_validator import OpenAPIV31SpecValidator

VERBS = {"get", "post", "put", "patch", "delete"}


def operations(document):
    return [
        (f"{verb} {path}", operation)
        for path, verbs in document["paths"].items()
        for verb, operation in verbs.items()
        if verb in VERBS
    ]


def references(part):
    if isinstance(part, dict):
        if "$ref" in part:
            yield part["$ref"]
        for child in part.values():
            yield from references(child)
    elif isinstance(part, list):
        for child in part:
            yield from references(child)


def test_the_document_is_valid(document):
    faults = OpenAPIV31SpecValidator(document).iter_errors()
    assert [(list(fault.absolute_path), fault.message[:80]) for fault in faults] == []


def test_every_call_of_the_contract_is_there(document):
    wanted = {
        "get /v1/models", "get /v1/models/{name}", "get /v1/planners",
        "post /v1/scenes", "get /v1/scenes", "get /v1/scenes/{scene}", "delete /v1/scenes/{scene}",
        "post /v1/scenes/{scene}/check", "post /v1/scenes/{scene}/fk", "post /v1/scenes/{scene}/ik",
        "post /v1/plans", "get /v1/plans", "get /v1/plans/{plan}", "get /v1/plans/{plan}/events",
        "post /v1/plans/{plan}/cancel", "get /v1/plans/{plan}/trajectory",
        "get /v1/plans/{plan}/replay.html",
        "post /v1/executions", "get /v1/executions", "get /v1/executions/{execution}",
        "get /v1/executions/{execution}/events", "post /v1/executions/{execution}/cancel",
        "get /healthz", "get /readyz", "get /metrics",
    }  # fmt: skip
    assert wanted <= {name for name, _ in operations(document)}


def test_operations_are_named_described_and_grouped(document):
    names = [operation["operationId"] for _, operation in operations(document)]
    assert len(names) == len(set(names))
    for name, operation in operations(document):
        assert operation["operationId"].isidentifier(), name
        assert operation["description"].endswith("."), name
        assert operation["tags"], name


def test_every_operation_declares_its_problems(document):
    for name, operation in operations(document):
        answers = operation["responses"]
        assert "500" in answers, name
        if "{" in name:
            assert "404" in answers, name
        if operation.get("requestBody"):
            assert {"400", "413"} <= set(answers), name
        if "/v1/" in name:
            assert "422" in answers, name
        for status, answer in answers.items():
            assert answer["description"], (name, status)
            if int(status) >= 400:
                assert set(answer["content"]) == {"application/problem+json"}, (name, status)


def test_what_is_made_leads_to_what_can_be_asked_of_it(document):
    """Every link is to an operation with that one parameter, and every such operation has one."""
    needed = {
        operation["operationId"]: [
            part["name"] for part in operation.get("parameters", []) if part["in"] == "path"
        ]
        for _, operation in operations(document)
    }
    made = {"createScene": "scene", "createPlan": "plan", "createExecution": "execution"}
    made |= {"growRegions": "regions", "reversePlan": "plan"}
    made |= {"createBatch": "batch", "createWebhook": "webhook"}
    for _, operation in operations(document):
        for status in {"201", "202"} & set(operation["responses"]):
            links = operation["responses"][status]["links"]
            named = made.pop(operation["operationId"])
            assert set(links) == {to for to, parts in needed.items() if parts == [named]}
            for to, link in links.items():
                assert link == {"operationId": to, "parameters": {named: "$response.body#/id"}}
    assert made == {}


def test_every_body_has_an_example(document):
    schemas = document["components"]["schemas"]
    for name, operation in operations(document):
        for content in operation.get("requestBody", {}).get("content", {}).values():
            target = content["schema"].get("$ref", "").split("/")[-1]
            shown = {**schemas.get(target, {}), **content}
            assert shown["examples"], name


def test_every_parameter_and_field_is_described(document):
    for name, operation in operations(document):
        for parameter in operation.get("parameters", []):
            assert parameter.get("description"), (name, parameter["name"])
    ours = {
        name: schema
        for name, schema in document["components"]["schemas"].items()
        if not name.endswith("Document")
    }
    for name, schema in ours.items():
        assert schema.get("description"), name
        for field, part in schema.get("properties", {}).items():
            assert part.get("description"), (name, field)


def test_every_reference_leads_somewhere(document):
    known = {f"#/components/schemas/{name}" for name in document["components"]["schemas"]}
    assert set(references(document)) <= known


def test_no_two_types_share_a_name(document):
    """Where they do, FastAPI tells them apart by the paths of our modules."""
    assert [name for name in document["components"]["schemas"] if "__" in name] == []


def test_examples_of_plans_are_accepted_by_their_type(document):
    from service.plans.models.request import PlanRequest

    for example in document["components"]["schemas"]["PlanRequest"]["examples"]:
        PlanRequest.model_validate(example)
