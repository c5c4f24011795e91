"""Pages of error codes: what their pictures and examples show is of that code, and still so."""

import json
import re
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator, ValidationError
from PIL import Image
from pydantic import TypeAdapter

from docs.site.error_examples import WITHOUT, example_section, examples, json_text
from docs.site.error_pages import PICTURES, error_pages, texts
from planning.errors import StageFailure
from service.api.failures.table import EVIDENCE, failure_errors, problem_errors
from tests.golden.error_examples import REWRITE, of_corpus, plain

ROOT = Path(__file__).parents[2]
API = json.loads((ROOT / "docs" / "reference" / "openapi.json").read_text(encoding="utf-8"))
EXAMPLES = examples()
ANSWERED = [code for code, example in EXAMPLES.items() if "answer" in example]
# Stages in which a robot is somewhere when they fail, and what else is seen.
_PLACED = {"goals", "search", "certify"}
_SEEN = {"start_mismatch", "schedule_not_found"}
# Failures of executions of which only words can tell.
_UNSEEN = {"illegal_transition", "driver_lost"}


@pytest.fixture(scope="module")
def pages() -> dict[str, str]:
    return dict(error_pages())


def test_what_can_be_seen_has_a_small_picture_that_is_described(pages: dict[str, str]) -> None:
    seen = {
        error.code
        for error in failure_errors()
        if issubclass(error, StageFailure) and error.stage in {*_PLACED, "execute"}
    }
    files = {file.stem: file for file in PICTURES.iterdir()}
    assert set(files) == (seen | _SEEN) - _UNSEEN
    told = {code: text["picture"] for code, text in texts().items() if "picture" in text}
    assert set(told) == set(files)
    assert len(set(told.values())) == len(told)
    for code, file in files.items():
        assert f"![{told[code]}](../../images/errors/{file.name})" in pages[_page(code)]
        assert 50 < len(told[code]) < 200
        assert not {"[", "]", "`"} & set(told[code])
        with Image.open(file) as picture:
            assert picture.size == (960, 600)
            assert len(set(picture.convert("L").resize((48, 30)).tobytes())) > 30  # not blank
        assert file.stat().st_size < 60_000
    assert sum(file.stat().st_size for file in files.values()) < 1_000_000


def _page(code: str) -> str:
    return f"reference/errors/{code}.md"


def test_every_code_has_an_example_or_a_reason_why_it_has_none(pages: dict[str, str]) -> None:
    codes = {error.code for error in EVIDENCE}
    assert {*EXAMPLES, *WITHOUT} == codes
    assert not set(EXAMPLES) & set(WITHOUT)
    assert list(EXAMPLES) == sorted(EXAMPLES)
    for code in codes:
        _, _, shown = pages[_page(code)].partition("## Example\n\n")
        assert code in shown or "command" in EXAMPLES.get(code, ()) or code in WITHOUT
    for reason in WITHOUT.values():
        assert re.fullmatch(r"[A-Z].{20,}\.", reason)


@pytest.mark.parametrize("code", ANSWERED)
def test_an_example_is_as_the_document_describes_answers_of_its_code(code: str) -> None:
    answer = EXAMPLES[code]["answer"]
    assert answer["code"] == code
    check = _model(code, "Problem" if "status" in answer else "Failure")
    check.validate(answer)
    with pytest.raises(ValidationError):
        check.validate({**answer, "code": "other"})


@pytest.mark.parametrize("code", ANSWERED)
def test_the_evidence_of_an_example_is_whole(code: str) -> None:
    """What the table of the page has is there, and nothing that it has not."""
    (evidence,) = (kind for error, kind in EVIDENCE.items() if error.code == code)
    schema = TypeAdapter[Any](evidence).json_schema()
    given = EXAMPLES[code]["answer"]["evidence"]
    assert set(schema.get("required", ())) <= set(given)
    assert set(given) <= set(schema.get("properties", ()))


def _model(code: str, kind: str) -> Draft202012Validator:
    """Return what checks answers of a code by the committed OpenAPI document."""
    name = "".join(word.capitalize() for word in code.split("_")) + kind
    schema = {"$ref": f"#/components/schemas/{name}", "components": API["components"]}
    return Draft202012Validator(schema)


def test_examples_of_refusals_are_the_recorded_answers() -> None:
    of_answers = {code: plain(example, {}) for code, example in of_corpus().items()}
    assert len(of_answers) >= 20
    found = {code: EXAMPLES[code] for code in of_answers}
    assert found == of_answers, f"`{REWRITE}` writes them anew"
    for code in of_answers:
        assert code in {error.code for error in problem_errors()}


def test_examples_have_nothing_of_the_machine_that_made_them() -> None:
    text = json.dumps(EXAMPLES)
    assert not re.search(r"/(tmp|root|home|work|dev/shm)/", text)
    assert not re.search(r"\b(scn|pln|reg|exe|bat|whk)_[0-9a-f]{16}", text)
    assert not re.search(r"\b20\d\d-\d\d-\d\dT", text)
    assert "timings" not in text


def test_examples_are_shown_as_the_json_that_they_are() -> None:
    for example in EXAMPLES.values():
        for part in (example.get("answer"), example.get("body")):
            assert json.loads(json_text(part)) == part
    lines = json_text({"a": list(range(40)), "b": {"c": 1}}).splitlines()
    assert max(map(len, lines)) < 100
    assert '"b": {"c": 1}' in lines[-2]
    with pytest.raises(KeyError):
        example_section("start_in_collision", None)
