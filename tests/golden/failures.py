"""The table of `docs/reference/failures.md`, which is generated from the types of evidence.

`python -m tests.golden.failures` writes it anew.
"""

from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from planning.errors import StageFailure, WayproofError
from service.api.failures.table import EVIDENCE, HTTP_ERROR, failure_errors, problem_errors
from service.api.failures.union import meaning
from service.errors import status_of

FILE = Path(__file__).parents[2] / "docs" / "reference" / "failures.md"
REWRITE = "python -m tests.golden.failures"
_BEGIN, _END = "<!-- begin of the generated table -->\n", "<!-- end of the generated table -->\n"


def table() -> str:
    """Return the table in Markdown: a row for each code."""
    rows = [_row(error, evidence) for error, evidence in EVIDENCE.items()]
    rows.append(f"| `{HTTP_ERROR}` | | any other | |")
    head = ["| code | stage | HTTP status | meaning, and evidence |", "|---|---|---|---|"]
    return "".join(f"{line}\n" for line in [*head, *rows])


def with_table(text: str) -> str:
    """Return the text of the guide with the table as it should be."""
    before, _, rest = text.partition(_BEGIN)
    return f"{before}{_BEGIN}{table()}{_END}{rest.partition(_END)[2]}"


def _row(error: type[WayproofError], evidence: Any) -> str:
    stage = error.stage if issubclass(error, StageFailure) else ""
    if not stage and error in failure_errors():
        stage = "any"
    status = str(status_of(error("x"))) if error in problem_errors() else ""
    properties: dict[str, Any] = TypeAdapter(evidence).json_schema().get("properties", {})
    members = [f"`{name}`: {_phrase(field['description'])}" for name, field in properties.items()]
    told = f" Evidence: {'; '.join(members)}." if members else ""
    return f"| `{error.code}` | {stage} | {status} | {meaning(error)}{told} |"


def _phrase(text: str) -> str:
    return (text[0].lower() + text[1:]).replace("|", "\\|")


if __name__ == "__main__":
    FILE.write_text(with_table(FILE.read_text(encoding="utf-8")), encoding="utf-8")
