"""A data folder as a version left it, as one text: the dump of its database, and its files.

The files are rows of a table of their own in the dump; the folder's path is `<data>` in all of it.
"""

import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

from tests.golden.service.answers import ask
from tests.golden.service.calls import Call, get, post
from tests.golden.service.masks import rounded
from tests.golden.service.plan_calls import plan
from tests.golden.service.summary import summary

DUMP = Path(__file__).with_name("database-0.1.sql")
ANSWERS = Path(__file__).with_name("database-0.1.json")
_DATABASE = "wayproof.sqlite"
_TABLE = "golden_files"
_PLACE = "<data>"
# The place in lists of the plan that was running: lists are read of what is older, and had ended.
_FIRST_OPEN = 8

# What is read of a stored data folder, by the calls that made it; the answers are recorded too.
READ_CALLS: tuple[Call, ...] = (
    get("scenes", "/v1/scenes"),
    get("scene", "/v1/scenes/{square}"),
    *(get(f"revision_{i}", f"/v1/scenes/{{square}}?revision={i}") for i in (1, 2, 3)),
    get("plans", f"/v1/plans?cursor={_FIRST_OPEN}"),
    get("failed_plans", f"/v1/plans?state=failed&cursor={_FIRST_OPEN}"),
    get("plans_of_the_cell", f"/v1/plans?scene={{cell}}&cursor={_FIRST_OPEN}"),
    *(
        get(f"{name}_plan", f"/v1/plans/{{{name}}}")
        for name in ("done", "failed", "back", "graphed")
    ),
    get("canceled_plan", "/v1/plans/{canceled}"),
    *(get(f"{name}_events", f"/v1/plans/{{{name}}}/events") for name in ("done", "failed", "back")),
    get("canceled_events", "/v1/plans/{canceled}/events"),
    get("trajectory", "/v1/plans/{done}/trajectory"),
    get("trajectory_exactly", "/v1/plans/{done}/trajectory?points=5&scale=0.5&polynomial=true"),
    get("trajectory_of_the_reversal", "/v1/plans/{back}/trajectory?format=csv&points=5"),
    get("graph", "/v1/plans/{graphed}/graph"),
    get("regions", "/v1/regions/{regions}"),
    get("regions_events", "/v1/regions/{regions}/events"),
    get("regions_of_the_scene", "/v1/scenes/{square}/regions"),
    get("executions", "/v1/executions"),
    get("execution", "/v1/executions/{execution}"),
    get("execution_events", "/v1/executions/{execution}/events"),
)
# The call that made the plan that succeeded: repeated under its key it gives the same plan.
NEAR = {"type": "joint", "positions": [0.1, -0.35, 0.3]}
DONE = plan("done", NEAR, headers={"idempotency-key": "stored"})
_SETTLE: tuple[Call, ...] = (
    get("searching", "/v1/plans/{running}", until=("stage", "search")),
    post("cancel", "/v1/plans/{running}/cancel"),
    get("canceled", "/v1/plans/{running}", until=("state", "canceled")),
    get("finished", "/v1/plans/{queued}", until=("state", "succeeded")),
)


def settle(service: Any, given: dict[str, Any]) -> None:
    """Wait until all that was stored has ended; what would run for ten minutes more is canceled."""
    for call in _SETTLE:
        ask(service, call, given).raise_for_status()


def read(service: Any, given: dict[str, Any]) -> dict[str, Any]:
    """Return the answers to what is read, by the names of calls; `given` has ids by name."""
    return {call.name: _told(ask(service, call, given)) for call in READ_CALLS}


def _told(answer: Any) -> dict[str, Any]:
    """Return what is compared of an answer: ids and instants too, for they are stored."""
    kind = answer.headers.get("content-type", "")
    body = _rounded(answer.json()) if kind == "application/json" else answer.text.splitlines()
    return {"status": answer.status_code, "content-type": kind, "body": summary(body)}


def _rounded(part: Any) -> Any:
    if isinstance(part, dict):
        return {key: _rounded(inner) for key, inner in part.items()}
    if isinstance(part, list):
        return [_rounded(inner) for inner in part]
    return rounded(part) if isinstance(part, float) else part


def dump(folder: Path) -> str:
    """Return a data folder as text, while a server works on it or not."""
    with closing(sqlite3.connect(folder / _DATABASE)) as source, closing(_copy(source)) as copy:
        copy.execute(f"CREATE TABLE {_TABLE} (path TEXT PRIMARY KEY, text TEXT NOT NULL)")
        for file in sorted(folder.rglob("*")):
            if file.is_file() and not file.name.startswith(_DATABASE):
                row = (str(file.relative_to(folder)), file.read_text(encoding="utf-8"))
                copy.execute(f"INSERT INTO {_TABLE} VALUES (?, ?)", row)
        copy.commit()
        text = "\n".join(copy.iterdump())
    return text.replace(str(folder), _PLACE) + "\n"


def load(text: str, folder: Path) -> None:
    """Make a data folder of what `dump` returned."""
    folder.mkdir(parents=True, exist_ok=True)
    with closing(sqlite3.connect(folder / _DATABASE)) as database:
        database.executescript(text.replace(_PLACE, str(folder)))
        for path, content in database.execute(f"SELECT path, text FROM {_TABLE}").fetchall():
            file = folder / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(content, encoding="utf-8")
        database.execute(f"DROP TABLE {_TABLE}")
        database.commit()


def _copy(source: sqlite3.Connection) -> sqlite3.Connection:
    copy = sqlite3.connect(":memory:")
    source.backup(copy)
    return copy
