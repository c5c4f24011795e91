"""Examples of errors as pages show them: what was asked, and what was answered.

`make record` writes those of refusals, `make pictures` those for which something has to go wrong.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

FILE = Path(__file__).with_name("error_examples.json")
# What is as short as this stands in one line.
_WIDTH = 92
# Codes that have no example, and the reason.
WITHOUT = {
    "client_left": "No one is left to be answered: it stands in the log and the metrics only.",
    "database_taken": "It takes two servers on one PostgreSQL, of which the first one does not"
    " answer for so long that the other one takes the lead.",
    "disk_full": "It takes a disk that is full while its database is not: as a rule the database"
    " is full first, and the answer is `database_unavailable`.",
    "host_lost": "It takes the machines of a cluster, one of which goes away during a job.",
    "internal_error": "It is a fault of Wayproof, and one that is known of is mended.",
    "scene_not_kept": "It takes records that were damaged, or that version 0.1 has written.",
    "unknown_job": "Answers say `not_found` with the kind of the resource, unless a job is deleted"
    " while it is being answered.",
}


def examples() -> dict[str, dict[str, Any]]:
    """Return examples by code: `call`, `headers`, `body`, `answer`, or `command`, `printed`."""
    found: dict[str, dict[str, Any]] = json.loads(FILE.read_text(encoding="utf-8"))
    return found


def example_section(code: str, example: Mapping[str, Any] | None) -> str:
    """Return the section with an example, in Markdown; the reason where there is none."""
    if example is None:
        return f"## Example\n\nThere is none here. {WITHOUT[code]}"
    if "command" in example:
        return (
            f"## Example\n\n{_fenced('console', f'$ {example["command"]}\n{example["printed"]}')}"
        )
    parts = ["## Example"]
    if example.get("call"):
        parts.append(_fenced("text", _request(example)))
    answer = example["answer"]
    what = f"Answer, with status {answer['status']}:" if "status" in answer else "The `failure`:"
    return "\n\n".join([*parts, what, _fenced("json", json_text(answer))])


def _request(example: Mapping[str, Any]) -> str:
    """Return a request as text: its first line, headers that matter here, and its body."""
    lines = [example["call"]]
    lines += [f"{name}: {value}" for name, value in example.get("headers", {}).items()]
    body = example.get("body")
    if body is not None:
        lines += ["", body if isinstance(body, str) else json_text(body)]
    return "\n".join(lines)


def json_text(part: Any, indent: int = 0) -> str:
    """Return JSON with every part in one line that fits into it."""
    flat = json.dumps(part, ensure_ascii=False)
    if indent + len(flat) <= _WIDTH or not isinstance(part, dict | list):
        return flat
    deeper = indent + 2
    if isinstance(part, dict):
        lines = [f"{json.dumps(name)}: {json_text(part[name], deeper)}" for name in part]
    else:
        lines = [json_text(inner, deeper) for inner in part]
    begin, end = "{}" if isinstance(part, dict) else "[]"
    inner = ",\n".join(f"{' ' * deeper}{line}" for line in lines)
    return f"{begin}\n{inner}\n{' ' * indent}{end}"


def _fenced(language: str, text: str) -> str:
    return f"```{language}\n{text}\n```"
