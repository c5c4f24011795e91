"""What the sources can give is in the lists of the document."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from ompl import base as ob

import planning
from planning.execute.states import ExecutionEvent, ExecutionState
from planning.refine.drake.program import SOLVER_NAME
from planning.refine.model.penalty_qp import solver_name
from service import lifespan
from service.api.document import known_values
from service.security.scopes import Scope

ROOT = Path(planning.__file__).parents[1]
GOLDEN = Path(__file__).parents[3] / "golden" / "service"
WORD = r"[a-z][a-z_ ]*"
# What stands for a text that differs from machine to machine.
MASK = "str"
# Of documents and of the command line: no name of a request.
NOT_ANSWERED = {"field", "key", "name", "scene", "value"}


def said(folder: str, *expressions: str) -> set[str]:
    """What the groups of expressions match in the sources of a folder."""
    folders = [ROOT / folder] if folder != "." else [ROOT / "planning", ROOT / "service"]
    files = (file for each in folders for file in each.rglob("*.py"))
    texts = [file.read_text(encoding="utf-8") for file in files]
    return {word for text in texts for each in expressions for word in re.findall(each, text)}


def matches(mark: Any, text: str) -> bool:
    return re.search(mark.__metadata__[0].pattern, text) is not None


def test_checks_of_certificates():
    words = said(
        "planning/certify",
        rf'\bCheck\(\s*(?:name=)?"({WORD})"',
        rf'\b_jump\("({WORD})"',
        rf'\bname = "({WORD})"',
        rf'\), "({WORD} continuity)"',
        rf'\(\("({WORD})", 1\)',
    )
    assert {"clearance", "form", "torque", "line rotation", "acceleration continuity"} <= words
    assert all(matches(known_values.CheckName, word) for word in words), words
    named = said(
        "planning/certify", r'f"((?:speed_zone|steering|tool_\w+|drake term|constraint) )\{'
    )
    assert len(named) >= 3
    for text in ("constraint 0: keep_in", "drake term 1: mine", "tool_speed arm::tcp"):
        assert matches(known_values.CheckName, text)
    for text in ("", "speed", "speed_zone", "clearance of what", "beside", "constraint x"):
        assert not matches(known_values.CheckName, text)
    for word in known_values.VERDICTS:
        assert matches(known_values.VerdictCheck, word)


def test_units_of_checks():
    units = said(
        "planning/certify",
        r'\bunit(?:: str)? ?= ?"([^"]+)"',
        r', "([^"]+)", (?:0\.0|np\.inf|resolution)\b',
        r'_UNITS = \{1: "([^"]+)"',
        r'_UNITS = \{1: "[^"]+", 2: "([^"]+)"',
        r'distance, CONFIGURATION_TOLERANCE, "([^"]+)"',
    )
    assert {"m", "rad", "rad or m", "1", "faults", "m/s^2", "s"} <= units
    assert units <= set(known_values.UNITS)


def test_outcomes_of_attempts():
    status = ob.PlannerStatus
    kinds = [getattr(status, name) for name in dir(status) if name.isupper()]
    ompl = {status(kind).asString() for kind in kinds}
    ours = said(
        "planning/search",
        r'AttemptReport\(planner, "(\w+)"',
        r'\bAttempt\("([\w ]+)"',
        r'status(?:, waypoints)? = "([\w ]+)"',
        r'outcome = "(\w+)"',
    )
    assert {"Timeout", "Exact solution"} <= ompl
    assert {"setup", "solved", "improving", "collides"} <= ours
    assert ompl | ours <= set(known_values.OUTCOMES)


def test_kinds_of_names():
    kinds = said(
        ".",
        r'UnknownName\.among\(\s*"([\w ]+)"',
        r'_validate_names\("([\w ]+)"',
        r'\bMark\("([\w ]+)"\)',
        r'"kind": "(planner)"',
    )
    assert {"frame", "planner", "joint or block", "part", "controller"} <= kinds
    assert kinds - NOT_ANSWERED <= set(known_values.NAMES)


def test_kinds_of_resources():
    kinds = said("service", r'UnknownResource\.of\("([\w ]+)"')
    queues = said("service", r'\bqueue="(\w+)"', r'\bQUEUE = "(\w+)"')
    assert {"scene", "revision", "mesh", "webhook", "batch", "job"} <= kinds
    assert kinds | (queues - {"query"}) <= set(known_values.RESOURCES)


def test_methods_solvers_queues_and_scopes():
    methods = said("planning/retime", r'"method": "(\w+)"')
    assert methods == set(known_values.METHODS)
    solvers = said("planning/refine", r'return "(Clarabel)" if .* else "interior point"')
    assert {*solvers, solver_name(), SOLVER_NAME} <= set(known_values.SOLVERS)
    assert lifespan._QUEUES == known_values.QUEUES
    assert [str(scope) for scope in Scope] == list(known_values.SCOPES)


def test_states_and_events():
    assert [str(state) for state in ExecutionState] == list(known_values.EXECUTION_STATES)
    assert [str(event) for event in ExecutionEvent] == list(known_values.EXECUTION_EVENTS)
    states = said(
        "service", r'\bstate(?:": | = )"([a-z ]+)"', r'"canceling" if is_ending else "([a-z ]+)"'
    )
    events = said("service", r'"event": "(\w+)", "legal"')
    assert {"canceling", "at its end", "unmoved"} <= states
    assert {"steer", "delete"} <= events
    assert states <= {*known_values.STATES, "unmoved"}
    assert events <= set(known_values.EVENTS)


def parts(answer: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Every part of an answer with the keys that lead to it; indices are left out."""
    yield path, answer
    if isinstance(answer, dict):
        for key, part in answer.items():
            yield from parts(part, (*path, key))
    elif isinstance(answer, list):
        for part in answer:
            yield from parts(part, path)


RECORDED = {
    ("checks", "name"): known_values.CheckName,
    ("failed", "name"): known_values.CheckName,
    ("checks", "unit"): known_values.UNITS,
    ("failed", "unit"): known_values.UNITS,
    ("refine", "solver"): known_values.SOLVERS,
    ("attempts", "outcome"): known_values.OUTCOMES,
    ("log", "outcome"): known_values.OUTCOMES,
    ("result", "cut_short"): known_values.CUTS,
}


@pytest.fixture(scope="module")
def answers():
    return list(parts(json.loads((GOLDEN / "answers.json").read_text(encoding="utf-8"))))


def test_what_was_recorded_is_known(answers):
    recorded = [(path[-2:], part) for path, part in answers if path[-2:] in RECORDED]
    texts = [
        (path, text)
        for path, part in recorded
        for text in (part if isinstance(part, list) else [part])
        if isinstance(text, str) and text != MASK
    ]
    assert {("checks", "name"), ("checks", "unit"), ("refine", "solver")} <= set(dict(texts))
    for path, text in texts:
        known = RECORDED[path]
        assert text in known if isinstance(known, tuple) else matches(known, text), (path, text)


def test_kinds_of_names_that_were_recorded(answers):
    faults = [part for _, part in answers if isinstance(part, dict) and "evidence" in part]
    kinds = {one["evidence"]["kind"] for one in faults if one.get("code") == "unknown_name"}
    assert {"frame", "group"} <= kinds <= set(known_values.NAMES)


def test_the_document_names_them(document):
    schemas = document["components"]["schemas"]

    def values(model, field):
        schema = schemas[model]["properties"][field]
        reference = schema.get("items", schema)["$ref"]
        return schemas[reference.rsplit("/", 1)[1]]["enum"]

    assert values("Check", "unit") == list(known_values.UNITS)
    assert values("AttemptReport", "outcome") == list(known_values.OUTCOMES)
    assert values("RefineReport", "solver") == list(known_values.SOLVERS)
    assert values("NameEvidence", "kind") == list(known_values.NAMES)
    assert values("QueueFullEvidence", "queue") == list(known_values.QUEUES)
    assert values("ScopeEvidence", "scopes") == list(known_values.SCOPES)
    assert values("RetimingEvidence", "method") == list(known_values.METHODS)
    assert values("TransitionEvidence", "legal") == list(known_values.EVENTS)
    assert values("TransitionEvidence", "state") == list(known_values.STATES)
    assert "unmoved" in values("NoTrajectoryEvidence", "state")
    for model, field in (
        ("Check", "name"),
        ("FailedCheck", "name"),
        ("PathBlockedEvidence", "check"),
    ):
        assert "drake term" in schemas[model]["properties"][field]["pattern"]
