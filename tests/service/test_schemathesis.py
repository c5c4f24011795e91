"""Schemathesis: whatever is sent, the answers are as declared and never a 5xx."""

import functools
import warnings

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from service.app import create_app
from service.settings import Settings
from tests.profiles import num_cases

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import schemathesis
    from schemathesis import GenerationMode
    from schemathesis.specs.openapi import checks

# Replays are megabytes.
NOT_CALLED = {"getReplay"}
CHECKS = [
    schemathesis.checks.not_a_server_error,
    checks.status_code_conformance,
    checks.content_type_conformance,
    checks.response_schema_conformance,
]
RULES = settings(
    max_examples=num_cases(6),
    deadline=None,
    derandomize=True,
    database=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=list(HealthCheck),
)


@functools.cache
def operations():
    document = create_app(Settings(engine="inline")).openapi()
    schema = schemathesis.openapi.from_dict(document)
    found = [result.ok() for result in schema.get_all_operations()]
    return {
        operation.definition.raw["operationId"]: operation
        for operation in found
        if operation.definition.raw["operationId"] not in NOT_CALLED
    }


def cases():
    """Every operation with good data, and with bad data if it takes any."""
    for name, operation in operations().items():
        raw = operation.definition.raw
        yield name, GenerationMode.POSITIVE
        if raw.get("parameters") or raw.get("requestBody"):
            yield name, GenerationMode.NEGATIVE


# Schemathesis draws from `random` in its strategies; Hypothesis seeds it, but complains.
@pytest.mark.filterwarnings("ignore:Do not use the `random` module inside strategies")
@pytest.mark.slow
@pytest.mark.parametrize(("name", "mode"), list(cases()))
def test_answers_are_as_declared(client, scene, solved, few_regions, name, mode):
    operation = operations()[name]
    known = {"scene": scene, "plan": solved["id"], "name": "ur5e", "regions": few_regions["id"]}

    @RULES
    @given(case=operation.as_strategy(generation_mode=mode), is_known=st.booleans())
    def check(case, is_known):
        if is_known:
            for parameter in set(case.path_parameters) & set(known):
                case.path_parameters[parameter] = known[parameter]
        sent = case.as_transport_kwargs(base_url="http://testserver")
        sent.pop("cookies", None)
        if isinstance(sent.get("data"), bytes | str):
            sent["content"] = sent.pop("data")
        answer = client.request(**sent)
        case.validate_response(answer, checks=CHECKS)

    check()
