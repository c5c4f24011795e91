"""Forms made from the OpenAPI document: complete, and what is filled in is what is asked."""

from types import SimpleNamespace

import pytest
import viser
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from service.studio.forms.fields import Choice, Flag, Group, Number, OneOf, Optional, Written
from service.studio.forms.form import Drawing
from service.studio.forms.options_panel import PLANNING_TIME, OptionsPanel
from service.studio.forms.schema import field_of, fields_of
from service.studio.forms.words import FormError, read
from tests.service.servers import until
from tests.service.studio.schema_values import (
    DOCUMENT,
    alternatives,
    completed,
    is_valid,
    resolved,
    values,
)

ELSEWHERE = frozenset({"scene", "group", "goal", "start", "revision"})
NAMES = ("PlanRequest", "Goal", "Constraint", "Retime", "Search")
REPEATED = settings(suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.fixture(scope="module")
def gui():
    server = viser.ViserServer("127.0.0.1", 0, verbose=False)
    yield server.gui
    server.stop()


def paths(schema, at=""):
    """The path and type of every value that a schema can hold, by a reader of our own."""
    for one in alternatives(schema):
        properties = one.get("properties", {})
        for name, inner in properties.items():
            yield from paths(inner, f"{at}.{name}")
        items = one.get("items", {})
        if any(resolved(each).get("properties") for each in alternatives(items)):
            yield from paths(items, at)
        elif not properties:
            yield at, one.get("type")


def shown(field, at=""):
    """The path of every input of a form, and its field."""
    here = f"{at}.{field.name}" if field.name else at
    if isinstance(field, Group):
        for inner in field.fields:
            yield from shown(inner, here)
    elif isinstance(field, OneOf):
        yield from shown_of_alternatives(field, here)
    elif hasattr(field, "inner"):
        own = f".{field.inner.name}" if field.inner.name else ""
        for path, found in shown(field.inner):
            yield f"{here}{path.removeprefix(own)}", found
    else:
        yield here, field


def shown_of_alternatives(field, here):
    if field.tag:
        yield f"{here}.{field.tag}", field
    for one in field.alternatives:
        if isinstance(one, Group):
            for inner in one.fields:
                yield from shown(inner, here)
        else:
            yield here, one


@pytest.mark.parametrize("name", NAMES)
def test_everything_that_can_be_asked_can_be_filled_in(name):
    schema = {"$ref": f"#/components/schemas/{name}"}
    wanted = set(paths(schema))
    found = {}
    for path, field in shown(field_of(DOCUMENT, name)):
        found.setdefault(path, []).append(field)
    assert {path for path, _ in wanted} == set(found)
    # Whatever is one value has an input of its own kind; by hand come only lists and maps.
    kinds = {"boolean": Flag, "number": Number, "integer": Number}
    for path, kind in wanted:
        if kind not in {"array", "object"}:
            assert any(not isinstance(field, Written) for field in found[path]), path
        if kind in kinds:
            assert any(isinstance(field, kinds[kind]) for field in found[path]), path


def test_words_of_the_schema_are_chosen_from_a_list():
    fields = dict(shown(fields_of(DOCUMENT, "PlanRequest", ELSEWHERE)))
    assert isinstance(fields[".refine.method"], Choice)
    enum = DOCUMENT["components"]["schemas"]["Refine"]["properties"]["method"]["enum"]
    assert list(fields[".refine.method"].options) == enum
    constraints = DOCUMENT["components"]["schemas"]["Constraint"]["discriminator"]["mapping"]
    offered = fields[".path_constraints.type"].alternatives
    assert {one.name for one in offered} == set(constraints)


OPTIONS = {
    **DOCUMENT["components"]["schemas"]["PlanRequest"],
    "properties": {
        name: inner
        for name, inner in DOCUMENT["components"]["schemas"]["PlanRequest"]["properties"].items()
        if name not in ELSEWHERE
    },
    "required": [],
}
GOAL = DOCUMENT["components"]["schemas"]["Goal"]


@REPEATED
@given(value=values(OPTIONS))
def test_options_that_are_filled_in_are_asked(gui, value):
    form = Drawing(gui, {}, lambda: None).input(fields_of(DOCUMENT, "PlanRequest", ELSEWHERE))
    assert form.value() == {}
    form.fill(value)
    found = form.value()
    assert is_valid(found, OPTIONS)
    assert completed(found, OPTIONS) == completed(value, OPTIONS)
    form.fill({})
    assert form.value() == {}
    form.remove()


def test_what_is_filled_in_while_the_options_are_drawn_stays(gui, monkeypatch):
    """A document takes seconds to be made and drawn, and a person does not wait."""
    draw = Drawing.input

    def draw_and_fill(self, field, *parent, **where):
        form = draw(self, field, *parent, **where)
        if isinstance(field, Group) and "seed" in {inner.name for inner in field.fields}:
            form._inputs["seed"].fill(7)
            form._inputs["search"]._inputs["planner"].fill("RRTstar")
        return form

    monkeypatch.setattr(Drawing, "input", draw_and_fill)
    cell, faults = SimpleNamespace(api=SimpleNamespace(document=DOCUMENT)), []
    place = gui.add_tab_group().add_tab("Options")
    panel = OptionsPanel(gui, place, cell, {}, faults.append)
    until(lambda: faults or "seed" in panel.options())
    found = panel.options()
    assert faults == []
    assert (found["seed"], found["search"]["planner"]) == (7, "RRTstar")
    assert found["search"]["allowed_planning_time"] == PLANNING_TIME
    panel.close()


@REPEATED
@given(value=values(GOAL), words=st.booleans())
@example(value={"type": "relative", "displacement": {}}, words=True)
def test_goals_that_are_filled_in_are_asked(gui, value, words):
    known = {"frame": ["world", "a"], "configuration.name": ["home"]} if words else {}
    form = Drawing(gui, known, lambda: None).input(field_of(DOCUMENT, "Goal"))
    form.fill(value)
    assert is_valid(form.value(), GOAL)
    assert completed(form.value(), GOAL) == completed(value, GOAL)
    form.remove()


@REPEATED
@given(number=st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_stay_within_their_bounds(gui, number):
    for path, field in shown(fields_of(DOCUMENT, "PlanRequest", ELSEWHERE)):
        if isinstance(field, Number):
            form = Drawing(gui, {}, lambda: None).input(field)
            form.fill(number)
            bound = "exclusiveMinimum" if field.excludes_lower else "minimum"
            schema = {bound: field.lower, "maximum": field.upper}
            known = {key: value for key, value in schema.items() if value is not None}
            assert is_valid(form.value(), known), path
            assert not field.is_whole or isinstance(form.value(), int)
            form.remove()


def test_what_is_switched_off_is_null_where_it_is_something_by_default(gui):
    field = next(
        inner for inner in field_of(DOCUMENT, "Retime").fields if inner.name == "sample_period"
    )
    assert isinstance(field, Optional)
    form = Drawing(gui, {}, lambda: None).input(field_of(DOCUMENT, "Retime"))
    form.fill({"sample_period": None, "num_points": 100})
    assert form.value() == {"sample_period": None, "num_points": 100}


@pytest.mark.parametrize(
    ("text", "value"),
    [("", None), ("[1e-3, 2]", [1e-3, 2]), ("{range: 0.3}", {"range": 0.3}), ("a, b", "a, b")],
)
def test_lists_and_maps_are_written_by_hand(text, value):
    assert read(text, "parameters") == value


def test_what_cannot_be_read_is_said_by_name():
    with pytest.raises(FormError, match="Tool limits"):
        read("[1, {", "tool_limits")
