"""Examples of errors for the guide, of the recorded answers to the corpus, where they have them.

`python -m tests.golden.error_examples` writes them anew; `record` also those that others make.
"""

import json
from typing import Any

from docs.site.error_examples import FILE, examples
from docs.site.error_pages import PICTURES
from service.api.failures.table import problem_errors
from tests.golden.service.__main__ import recorded
from tests.golden.service.answers import CALLS
from tests.golden.service.calls import Call, filled
from tests.golden.service.masks import Masks, rounded

REWRITE = "python -m tests.golden.error_examples"
# Longer requests would hide what is wrong with them.
_LONGEST_REQUEST = 600
# Which of several refusals of a code says most; else the first one.
_CHOSEN = {
    "not_found": "unknown_scene",
    "request_invalid": "unknown_inner_field",
    "scene_invalid": "zero_box",
    "unknown_name": "unknown_configuration",
}
# What stands for values that are not recorded: an example has to be whole.
# As the service writes them: what is recorded is sorted.
_ORDER = ("type", "title", "status", "code", "detail", "evidence", "errors")
_MASKED = ("<digest>", "<seconds>", "<measured>", "<moving>")


def of_corpus() -> dict[str, dict[str, Any]]:
    """Return the examples that the corpus has, by code: refusals that are recorded whole.

    Those of which there are pictures are made with these.
    """
    told = recorded()
    given = {name: each["body"] for name, each in told.items()}
    known = {error.code for error in problem_errors()} - {each.stem for each in PICTURES.iterdir()}
    found: dict[str, dict[str, Any]] = {}
    for call in CALLS:
        answer = given[call.name]
        code = str(answer.get("code")) if isinstance(answer, dict) else ""
        is_whole = not any(mask in json.dumps(answer) for mask in _MASKED)
        is_chosen = _CHOSEN.get(code, call.name) == call.name
        if code in known and is_chosen and is_whole and told[call.name]["status"] >= 400:
            found.setdefault(code, _example(call, answer, given))
    return found


def _example(call: Call, answer: dict[str, Any], given: dict[str, Any]) -> dict[str, Any]:
    ids = {
        name: part["id"] for name, part in given.items() if isinstance(part, dict) and "id" in part
    }
    example: dict[str, Any] = {"call": f"{call.method} {call.path.format_map(ids)}"}
    if call.headers:
        example["headers"] = {name.title(): value for name, value in call.headers.items()}
    body = call.body.decode() if isinstance(call.body, bytes) else filled(call.body, given)
    if body is not None and len(json.dumps(body)) <= _LONGEST_REQUEST:
        example["body"] = body
    ordered = {name: answer[name] for name in _ORDER if name in answer}
    return {**example, "answer": {**ordered, **answer}}


def record(made: dict[str, dict[str, Any]], places: dict[str, str]) -> None:
    """Write examples in the place of those that there were of their codes.

    Ids are numbered, digests and instants masked, and numbers rounded, as in recorded answers.

    Args:
        made: Examples by code.
        places: Folders and addresses of this machine, and what is shown for them.
    """
    kept = examples() if FILE.is_file() else {}
    for code, example in made.items():
        kept[code] = plain(example, places)
    ordered = {code: kept[code] for code in sorted(kept)}
    FILE.write_text(json.dumps(ordered, indent=1) + "\n", encoding="utf-8")


def plain(example: dict[str, Any], places: dict[str, str]) -> dict[str, Any]:
    """Return an example without what changes from run to run: `record`."""
    found: dict[str, Any] = _plain(example, Masks(places))
    return found


def _plain(part: Any, masks: Masks) -> Any:
    if isinstance(part, dict):
        return {name: _plain(inner, masks) for name, inner in part.items()}
    if isinstance(part, list | tuple):
        return [_plain(inner, masks) for inner in part]
    if isinstance(part, float):
        return rounded(part)
    return masks.text(part) if isinstance(part, str) else part


if __name__ == "__main__":
    record(of_corpus(), {})
