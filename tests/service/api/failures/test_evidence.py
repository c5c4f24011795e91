"""Every error has a model of its evidence, and what is told fits it strictly."""

import json
import re
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages

import pytest
from pydantic import TypeAdapter, ValidationError

import service
from planning.errors import InputError, StageFailure, WayproofError
from service.api.error_responses import CODES
from service.api.failures.failure import Failure, OtherFailure, failures
from service.api.failures.problem import Problem, problems
from service.api.failures.table import EVIDENCE, HTTP_ERROR
from service.jobs.worker.protocol import RemoteFailure

ANSWERS = Path(__file__).parents[3] / "golden" / "service" / "answers.json"
# Without a code of its own: bases, and what carries the code of another.
BASES = {RemoteFailure}
# What stands for numbers in the corpus, which depend on the machine.
MASKED = {"<seconds>", "<measured>"}


def classes_below(base):
    return {base} | {leaf for child in base.__subclasses__() for leaf in classes_below(child)}


def errors():
    for module in walk_packages(service.__path__, "service."):
        if not module.name.endswith("__main__"):
            import_module(module.name)
    ours = {e for e in classes_below(WayproofError) if not e.__module__.startswith("tests")}
    return {e for e in ours if "code" in vars(e) and e is not WayproofError}


def unmasked(part):
    """Return a value of the corpus with a number for every mask of a number."""
    if isinstance(part, dict):
        return {
            key: inner if key == "during" else unmasked(inner)
            for key, inner in part.items()
            # The names of the timings of a cancel are masked as well.
            if (key, inner) != ("timings", "<seconds>")
        }
    if isinstance(part, list):
        return [unmasked(inner) for inner in part]
    return 1 if str(part) in MASKED else part


def told(part):
    """Yield all failures and problems in an answer."""
    if isinstance(part, dict):
        if isinstance(part.get("code"), str) and isinstance(part.get("evidence"), dict):
            yield part
        for inner in part.values():
            yield from told(inner)
    elif isinstance(part, list):
        for inner in part:
            yield from told(inner)


def strictly(one):
    """Check a failure or a problem against the member of its code."""
    member = (failures() if "stage" in one else problems())[one["code"]]
    member.model_validate_json(json.dumps(one), strict=True)


def in_corpus():
    found = told(unmasked(json.loads(ANSWERS.read_text())))
    # A digest of what is long stands for some failures: the types of its parts.
    return [one for one in found if one["code"] != "str"]


def test_every_error_has_a_model_of_its_evidence():
    assert set(EVIDENCE) == errors() - BASES
    known = {error.code for error in EVIDENCE} | {HTTP_ERROR}
    assert set(CODES.values()) <= set(problems())
    # Those that no client reads.
    unread = {"database_in_use", "database_too_new", "database_unrecognized", "backup_invalid"}
    unread |= {"records_exist", "client_left", "key_exists", "unguarded"}
    unread |= {"backup_impossible"}
    assert set(failures()) | set(problems()) | unread == known
    # What waits for its robots may be refused once they are free.
    late = {"robot_state_unknown", "start_mismatch", "not_found"}
    assert set(failures()) == late | {
        error.code for error in EVIDENCE if issubclass(error, StageFailure | InputError)
    }


def test_every_member_of_evidence_is_described():
    for error, evidence in EVIDENCE.items():
        schema = TypeAdapter(evidence).json_schema()
        for part in [schema, *schema.get("$defs", {}).values()]:
            for name, field in part.get("properties", {}).items():
                assert field.get("description"), (error.code, part.get("title"), name)


def test_the_documentation_of_errors_names_members_of_their_evidence():
    for error, evidence in EVIDENCE.items():
        doc = " ".join((error.__doc__ or "").split())
        _, _, said = doc.replace("Evidence:", "evidence:").partition("evidence:")
        known = str(TypeAdapter(evidence).json_schema())
        for name in re.findall(r"`([a-z_]+)`", said.split(". ")[0]):
            assert f"'{name}'" in known, (error.__name__, name)


@pytest.mark.parametrize("one", in_corpus(), ids=lambda one: one["code"])
def test_what_the_corpus_tells_fits_strictly(one):
    strictly(one)


def test_the_corpus_tells_much():
    assert len({str(one["code"]) for one in in_corpus()}) >= 25


def test_other_members_are_kept_and_missing_ones_are_not_made_up():
    pair = {"bodies": ["a", "b"], "distance": -1, "margin": 0, "depth": 1, "points": []}
    evidence = {"pairs": [{**pair, "new": 1}], "more": None}
    failure = {"code": "start_in_collision", "stage": "goals", "detail": "x", "evidence": evidence}
    given = {**failure, "timings": {}}
    strictly(given)
    assert json.loads(Failure.model_validate(given).model_dump_json()) == given
    member = failures()["start_in_collision"].model_validate_json(json.dumps(given))
    assert json.loads(member.model_dump_json()) == given


def test_evidence_that_does_not_fit_is_told_apart():
    wrong = {"code": "start_in_collision", "stage": "", "detail": "", "evidence": {"pairs": 1}}
    with pytest.raises(ValidationError, match=r"evidence\.pairs"):
        strictly(wrong)


@pytest.mark.parametrize("code", ["of_yesterday", "start_in_collision"])
def test_what_an_older_version_stored_is_passed_on(code):
    stored = {"code": code, "stage": "s", "detail": "d", "evidence": {"a": 1}, "timings": {}}
    assert Failure.model_validate(stored).model_dump() == stored
    assert OtherFailure.model_validate(stored).model_dump() == stored


def test_the_document_tells_the_members_apart(document):
    schemas = document["components"]["schemas"]
    for model, members in ((Failure, failures()), (Problem, problems())):
        union = schemas[model.__name__]
        mapping = union["discriminator"]["mapping"]
        assert set(mapping) == set(members)
        assert len(union["oneOf"]) == len(members) + 1
        codes = schemas[f"{model.__name__}Code"]["enum"]
        assert codes == sorted(members)
        other = schemas[f"Other{model.__name__}"]["properties"]["code"]
        assert other["not"] == {"$ref": f"#/components/schemas/{model.__name__}Code"}
        for code, reference in mapping.items():
            assert schemas[reference.split("/")[-1]]["properties"]["code"]["const"] == code
