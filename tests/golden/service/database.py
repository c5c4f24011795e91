"""Writes the data folder of this version, as a server leaves it that is killed while it plans.

`python -m tests.golden.service.database` makes the dump and the answers of `stored`. Later versions
are held against the dump, so this runs once for a version, and never for one that is past. With
`--answers` only the answers are recorded, as this checkout gives them to the dump that there is:
for changes of the interface that are meant.
"""

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

from tests.golden.service.answers import ask, client
from tests.golden.service.calls import Call, From, get, post
from tests.golden.service.plan_calls import plan
from tests.golden.service.scene_calls import CELL, SQUARE
from tests.golden.service.stored import ANSWERS, DONE, DUMP, NEAR, dump, load, read, settle

_OUT = {"type": "joint", "positions": [-0.3, 0.3, 0.0]}
_LONG = {"allowed_planning_time": 600.0}
_GROW = {"group": "body", "num_regions": 2, "num_free": 100, "iterations": 1, "along": "nothing"}
_MAKE: tuple[Call, ...] = (
    post("square", "/v1/scenes", SQUARE),
    post("cell", "/v1/scenes", CELL),
    Call(
        "edit",
        "PATCH",
        "/v1/scenes/{square}",
        {"operations": [{"op": "remove", "object": "coin"}], "revision": 1},
    ),
    DONE,
    plan(
        "graphed",
        {"type": "configuration", "name": "beyond"},
        search={"keep_graph": True, "planner": "RRT"},
        refine={"method": "none"},
        retime={"sample_period": None, "num_points": 5},
    ),
    plan("failed", {"type": "joint", "positions": [0.3, 0, 0]}),
    post("back", "/v1/plans/{done}/reverse?wait=60"),
    plan("canceled", _OUT, "cell", wait="", search=_LONG),
    get("searching", "/v1/plans/{canceled}", until=("stage", "search")),
    post("cancel", "/v1/plans/{canceled}/cancel"),
    get("ended", "/v1/plans/{canceled}", until=("state", "canceled")),
    post("regions", "/v1/scenes/{square}/regions?wait=60", {**_GROW, "allowed_time": 3600.0}),
    post("execution", "/v1/executions?wait=60", {"plan": From("done"), "speed": 50.0}),
    get("moved", "/v1/scenes/{square}"),
)
_LEAVE: tuple[Call, ...] = (
    plan("running", _OUT, "cell", wait="", search=_LONG),
    get("begun", "/v1/plans/{running}", until=("stage", "search")),
    plan("queued", NEAR, wait="", start=[0.3, -0.35, 0]),
)
_END = post("end", "/v1/plans/{running}/cancel")


def main() -> None:
    """Write the dump and the answers, or the answers alone."""
    parser = argparse.ArgumentParser(prog="python -m tests.golden.service.database")
    help_ = "record anew what this checkout answers to the stored dump"
    parser.add_argument("--answers", action="store_true", help=help_)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name).resolve()
        if parser.parse_args().answers:
            ids, answers = _read_anew(folder)
        else:
            ids, answers = _made(folder)
    text = json.dumps({"ids": ids, "answers": answers}, indent=1)
    ANSWERS.write_text(text + "\n", encoding="utf-8")


def _made(folder: Path) -> tuple[dict[str, str], dict[str, Any]]:
    """Write the dump; return ids by the names of calls, and answers."""
    given: dict[str, Any] = {}

    def make(service: Any, calls: tuple[Call, ...]) -> None:
        for call in calls:
            answer = ask(service, call, given)
            answer.raise_for_status()
            given[call.name] = answer.json()

    with client(folder) as service:
        make(service, _MAKE)
        answers = read(service, given)
        make(service, _LEAVE)
        DUMP.write_text(dump(folder), encoding="utf-8")
        make(service, (_END,))
    return {name: found["id"] for name, found in given.items() if "id" in found}, answers


def _read_anew(folder: Path) -> tuple[dict[str, str], dict[str, Any]]:
    ids: dict[str, str] = json.loads(ANSWERS.read_text(encoding="utf-8"))["ids"]
    load(DUMP.read_text(encoding="utf-8"), folder)
    with client(folder) as service:
        given = {name: {"id": identifier} for name, identifier in ids.items()}
        settle(service, given)
        return ids, read(service, given)


if __name__ == "__main__":
    main()
