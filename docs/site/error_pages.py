"""A page for each error code: what it means, its usual cause, the fix, and its evidence.

Meaning, stage, status and evidence are those of the classes; causes, fixes and what is to be seen
in pictures are in `errors.yaml`, and answers that were recorded in `error_examples.json`.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml
from pydantic import TypeAdapter

from docs.site.error_examples import example_section, examples
from docs.site.schema_tables import cell
from planning.errors import StageFailure, WayproofError
from service.api.failures.table import EVIDENCE, failure_errors, problem_errors
from service.api.failures.union import meaning
from service.errors import status_of

_TEXTS = Path(__file__).with_name("errors.yaml")
# What `make pictures` takes of failures where something is to be seen.
PICTURES = Path(__file__).parents[1] / "images" / "errors"
_UP = "../../"
_TYPE = "urn:wayproof:problem:"


def texts() -> dict[str, dict[str, str]]:
    """Return `cause` and `fix` of each code, and of some what a `picture` shows."""
    found: dict[str, dict[str, str]] = yaml.safe_load(_TEXTS.read_text(encoding="utf-8"))
    return found


def error_pages() -> Iterator[tuple[str, str]]:
    """Yield path and text of the page of each code, and of their list."""
    written, made = texts(), examples()
    rows = []
    for error, evidence in EVIDENCE.items():
        page = _page(error, evidence, written[error.code], made.get(error.code))
        yield f"reference/errors/{error.code}.md", page
        rows.append(f"| [`{error.code}`]({error.code}.md) | {meaning(error)} |")
    yield (
        "reference/errors/index.md",
        "# Errors\n\n"
        f"A page for each code. The `type` of a problem is `{_TYPE}` and the code: its page is"
        " the one of that name. How errors travel is in [Failures](../failures.md).\n\n"
        "| code | meaning |\n|---|---|\n" + "\n".join(rows) + "\n",
    )


def _page(
    error: type[WayproofError],
    evidence: Any,
    text: Mapping[str, str],
    example: Mapping[str, Any] | None,
) -> str:
    parts = [f"# {error.code}", meaning(error)]
    facts = [f"- code: `{error.code}`"]
    if issubclass(error, StageFailure) and error.stage:
        facts.append(f"- stage: `{error.stage}`")
    if error in problem_errors():
        facts.append(f"- HTTP status: {status_of(error('x'))}")
        facts.append(f"- problem `type`: `{_TYPE}{error.code}`")
    if error in failure_errors():
        facts.append("- met as: `failure` of a job or of an answer")
    parts.append("\n".join(facts))
    parts += [f"**Usual cause.** {text['cause']}", f"**Fix.** {text['fix']}"]
    if "picture" in text:
        parts.append(f"![{text['picture']}]({_UP}images/errors/{error.code}.webp)")
    properties = TypeAdapter(evidence).json_schema().get("properties", {})
    if properties:
        rows = [
            f"| `{name}` | {cell(field['description'])} |" for name, field in properties.items()
        ]
        parts.append("\n".join(["## Evidence\n", "| member | meaning |", "|---|---|", *rows]))
    parts.append(example_section(error.code, example))
    if error in failure_errors() and issubclass(error, StageFailure):
        parts.append(
            "`GET /v1/plans/{id}/failure.html` shows a failed plan, and its `bundle.zip` fails"
            " again elsewhere: [show and replay](../../how-to/show-and-replay.md)."
        )
    return "\n\n".join(parts) + "\n"
