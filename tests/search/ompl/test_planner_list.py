"""Every planner that the wheel binds is listed, and its parameters are real."""

import pytest
from ompl import base as ob
from ompl import geometric as og

from planning.errors import ProblemInvalid, UnknownName
from planning.search.ompl.parameters import declared_parameters, set_parameters, value_of
from planning.search.ompl.planner_list import check_planner, make_planner, ompl_cards, planner_names

BOUND = [
    "AORRTC",
    "BFMT",
    "BITstar",
    "BKPIECE1",
    "FMT",
    "InformedRRTstar",
    "KPIECE1",
    "LBKPIECE1",
    "PRM",
    "PRMstar",
    "RRT",
    "RRTConnect",
    "RRTstar",
    "SORRTstar",
]

# Declared, but without a setter in the wheel, or with one that does nothing or harm.
NOT_SETTABLE = {
    ("BFMT", "balanced"),
    ("BFMT", "optimality"),
    ("BFMT", "extended_fmt"),
    ("BITstar", "delay_rewiring_to_first_solution"),
    ("BITstar", "use_strict_queue_ordering"),
}

# Parameters that OMPL accepts only together with others.
NOT_ALONE = {("BITstar", "use_just_in_time_sampling")}


def planner_named(name):
    space = ob.RealVectorStateSpace(2)
    space.setBounds(0.0, 1.0)
    information = ob.SpaceInformation(space)
    information.setStateValidityChecker(lambda _: True)
    information.setup()
    planner = getattr(og, name)(information)
    planner.setup()
    return planner


def printed(planner):
    lines = (line.partition(" = ") for line in planner.printSettings().splitlines()[1:])
    return {name: value for name, equals, value in lines if equals}


def test_every_planner_of_the_wheel_is_listed():
    assert set(planner_names()) >= set(BOUND)
    assert [card.name for card in ompl_cards()] == planner_names()


@pytest.mark.parametrize("name", BOUND)
def test_every_declared_parameter_can_be_set(name):
    cards = {card.name: card for card in ompl_cards()}
    known = {parameter.name for parameter in cards[name].parameters}
    missing = set(printed(planner_named(name))) - known
    assert {(name, parameter) for parameter in missing} <= NOT_SETTABLE


@pytest.mark.parametrize("name", BOUND)
def test_a_setter_changes_the_parameter_that_it_is_listed_for(name):
    for parameter, setter in declared_parameters(planner_named(name)).items():
        planner = planner_named(name)
        before = value_of(planner, setter)
        changed = (not before) if isinstance(before, bool) else _another(parameter, before)
        if (name, parameter) in NOT_ALONE:
            with pytest.raises(ProblemInvalid, match="refuses"):
                set_parameters(planner, {parameter: changed})
            continue
        set_parameters(planner, {parameter: changed})
        assert value_of(planner, setter) == changed
        if parameter in printed(planner):
            assert float(printed(planner)[parameter]) == pytest.approx(float(changed))


def _another(parameter, value):
    if isinstance(value, int):
        return value + 17
    return 1.5 if parameter in {"rewire_factor", "radius_multiplier"} else 0.375


def test_numbers_may_come_as_text():
    planner = planner_named("RRT")
    set_parameters(planner, {"range": "0.5", "intermediate_states": "true"})
    assert planner.getRange() == 0.5
    assert planner.getIntermediateStates() is True


def test_an_unknown_planner_is_named_with_its_nearest():
    with pytest.raises(UnknownName) as caught:
        check_planner("RRTConect", {})
    assert caught.value.evidence["kind"] == "planner"
    assert caught.value.evidence["nearest"][0] == "RRTConnect"


def test_an_unknown_parameter_is_named_with_those_there_are():
    with pytest.raises(UnknownName) as caught:
        check_planner("RRTConnect", {"goal_bias": 0.1})
    assert caught.value.evidence["kind"] == "parameter"
    assert "range" in caught.value.evidence["known"]


@pytest.mark.parametrize(
    ("planner", "parameter", "value"),
    [
        ("RRT", "goal_bias", 1.5),
        ("RRT", "goal_bias", -0.1),
        ("RRT", "goal_bias", float("nan")),
        ("RRT", "goal_bias", "often"),
        ("RRT", "goal_bias", True),
        ("RRT", "range", float("inf")),
        ("RRT", "intermediate_states", 2),
        ("FMT", "num_samples", 10.5),
        ("FMT", "num_samples", 10**9),
        ("FMT", "radius_multiplier", 0.0),
        ("AORRTC", "range", -1.0),
        ("BITstar", "samples_per_batch", -3),
    ],
)
def test_silly_values_are_refused_by_name(planner, parameter, value):
    with pytest.raises(ProblemInvalid) as caught:
        check_planner(planner, {parameter: value})
    assert caught.value.evidence["field"] == f"search.parameters.{parameter}"
    assert parameter in caught.value.detail
    assert "must be" in caught.value.detail


def information_of(reach):
    space = ob.RealVectorStateSpace(7)
    space.setBounds(-reach, reach)
    information = ob.SpaceInformation(space)
    information.setStateValidityChecker(lambda _: True)
    information.setup()
    return information


@pytest.mark.parametrize(
    ("reach", "parameters", "expected"),
    [
        (3.0, {}, 0.5),
        (3.0, {"range": "0"}, 0.5),
        (3.0, {"range": 1.25}, 1.25),
        (0.1, {}, 0.2 * 0.2 * 7**0.5),
    ],
)
def test_steps_of_rrtconnect_are_short_by_default(reach, parameters, expected):
    planner = make_planner(information_of(reach), "RRTConnect", parameters)
    planner.setup()
    assert planner.getRange() == pytest.approx(expected)


def test_a_cached_check_does_not_accept_equal_values_of_other_types():
    check_planner("RRT", {"intermediate_states": True})
    check_planner("RRT", {"intermediate_states": "1"})
    for _ in range(2):
        with pytest.raises(ProblemInvalid):
            check_planner("RRT", {"intermediate_states": 2})
        with pytest.raises(ProblemInvalid):
            check_planner("RRT", {"goal_bias": True})
        check_planner("RRT", {"goal_bias": 1})


@pytest.mark.parametrize("card", ompl_cards(), ids=lambda card: card.name)
def test_a_listed_default_is_accepted(card):
    for parameter in card.parameters:
        check_planner(card.name, {parameter.name: parameter.default})
