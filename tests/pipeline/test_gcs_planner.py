"""The GCS planner: certified, repeatable, with OMPL outside of the regions."""

import json
import pickle
import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import planning
from planning.api.grow_regions import domain_of
from planning.api.planners import list_planners
from planning.domain.goals.goal import ConfigurationGoal
from planning.domain.planner.regions import RegionOptions, Regions
from planning.domain.request.constraint import TightLimits
from planning.domain.request.options import SearchOptions
from planning.domain.request.problem import PlanningProblem
from planning.errors import ProblemInvalid, UnknownName
from planning.pipeline import plan as pipeline
from planning.regions.hit_and_run import hit_and_run
from planning.world.collision.collision_check import DrakeCollisionOracle
from tests.clocks import no_hurry
from tests.conftest import bundled_world

# An L in a square with a wall across most of it.
SCENE = planning.parse_scene({
    "name": "square",
    "robots": [{"name": "body", "model": "planar_l", "positions": [0.3, -0.35, 0.0]}],
    "objects": [
        {"name": "wall", "shape": {"box": [0.8, 0.02, 0.06]}, "pose": {"position": [0.2, 0, 0.03]}}
    ],
    "configurations": {"beyond": {"group": "body", "positions": [0.3, 0.3, 0.0]}},
})
OPTIONS = RegionOptions(num_regions=12, num_free=2000, iterations=2, coverage=1.0)


@cache
def square(*, kernel: bool = True) -> planning.World:
    return planning.load_world(SCENE, kernel=kernel)


def grown(options: RegionOptions = OPTIONS, **arguments) -> Regions:
    deadline = no_hurry(60.0)
    return planning.grow_regions(square(), "body", deadline=deadline, options=options, **arguments)


@pytest.fixture(scope="module")
def regions() -> Regions:
    return grown()


def plan(regions: Regions | None, **changes) -> planning.MotionPlan:
    search = SearchOptions(planner="GCS", allowed_planning_time=30.0)
    problem = PlanningProblem("body", ConfigurationGoal("beyond"), search=search, regions=regions)
    deadline = no_hurry(30.0)
    return pipeline.plan(replace(problem, **changes), square(), deadline=deadline)


def test_regions_are_free_by_drake_alone(regions):
    """2,000 random configurations of each, by a world without the native kernel."""
    world = square(kernel=False)
    group = world.group("body")
    judge = DrakeCollisionOracle(world.drake, group, world.state, world.margins())
    generator = np.random.default_rng(11)
    for region in regions.regions:
        begin = np.repeat(region.center[None], 2000, axis=0)
        shape = np.diag(regions.upper - regions.lower)
        qs = hit_and_run(begin, (region.normals, region.offsets), shape, 20, generator)
        assert region.contains(qs).all()
        # less than 3 in num_free collide: 95 % of all regions have 3 of these at most
        assert (~judge.are_free(qs)).sum() <= 3


def test_a_motion_inside_is_certified_and_repeatable(regions):
    found = plan(regions)
    report = found.stages.search
    assert found.certificate.proven
    assert report.planner == "GCS"
    assert report.regions.is_inside
    assert report.regions.fallback == ""
    assert report.regions.digest == regions.digest
    assert set(report.regions.considered) <= set(range(len(regions.regions)))
    assert plan(regions).digest == found.digest
    again = pickle.loads(pickle.dumps(regions))
    assert again == regions
    assert plan(Regions.from_json(json.loads(json.dumps(regions.as_json)))).digest == found.digest


def test_growth_is_repeatable():
    few = replace(OPTIONS, num_regions=2)
    assert grown(few).digest == grown(few).digest != grown(few, seed=1).digest


def test_outside_of_regions_ompl_plans_and_the_report_says_so(regions):
    only_last = replace(regions, regions=regions.regions[-1:], portals=())
    cases = {"outside": only_last, "not connected": replace(regions, portals=())}
    for reason, fewer in cases.items():
        found = plan(fewer)
        assert found.certificate.proven
        assert found.stages.search.planner == "RRTConnect"
        assert not found.stages.search.regions.is_inside
        assert reason in found.stages.search.regions.fallback


def test_the_stand_in_can_be_chosen_and_has_its_own_parameters(regions):
    parameters = {"max_regions": 4, "range": 0.3}
    search = SearchOptions(
        planner=("GCS", "RRT"), parameters=parameters, allowed_planning_time=30.0
    )
    found = plan(replace(regions, portals=()), search=search)
    assert found.stages.search.planner == "RRT"


def test_path_constraints_are_left_to_ompl(regions):
    yaw = square().group("body").position_names[2]
    found = plan(regions, constraints=(TightLimits({yaw: (-2.0, 2.0)}),))
    assert "constraints" in found.stages.search.regions.fallback


def test_regions_that_do_not_fit_are_refused(regions):
    with pytest.raises(ProblemInvalid, match="needs regions"):
        plan(None)
    with pytest.raises(ProblemInvalid, match="margin"):
        plan(regions, margin=0.01)
    for changes in ({"scene": "0" * 64}, {"group": "other"}):
        with pytest.raises(ProblemInvalid, match=next(iter(changes))):
            plan(replace(regions, **changes))


@pytest.mark.parametrize("value", [0, 2.5, "many", True])
def test_parameters_out_of_range_are_refused(regions, value):
    search = SearchOptions(planner="GCS", parameters={"max_regions": value})
    with pytest.raises(ProblemInvalid, match="max_regions"):
        plan(regions, search=search)


def test_the_domain_is_bounded_or_refused():
    world = square()
    group = world.group("body")
    lower, upper = domain_of(world, group, RegionOptions())
    np.testing.assert_allclose(lower, [-0.5, -0.5, -np.pi])
    np.testing.assert_allclose(upper, [0.5, 0.5, np.pi])
    yaw = group.position_names[2]
    lower, upper = domain_of(world, group, RegionOptions(bounds={yaw: (-0.1, 0.2)}))
    assert (lower[2], upper[2]) == (-0.1, 0.2)
    lower, upper = domain_of(world, group, RegionOptions(bounds={yaw: (0.0, 6.2832)}))
    assert (lower[2], upper[2]) == (0.0, 6.2832)
    with pytest.raises(ProblemInvalid, match="one turn") as wide:
        domain_of(world, group, RegionOptions(bounds={yaw: (-4.0, 4.0)}))
    assert wide.value.evidence["bounds"] == [-4.0, 4.0]
    with pytest.raises(UnknownName):
        domain_of(world, group, RegionOptions(bounds={"nothing": (0, 1)}))
    x = group.position_names[0]
    with pytest.raises(
        ProblemInvalid, match=re.escape("[5, 6] and its limits [-0.5, 0.5]")
    ) as said:
        domain_of(world, group, RegionOptions(bounds={x: (5.0, 6.0)}))
    assert said.value.evidence["bounds"] == [5.0, 6.0]
    window = bundled_world("window_3d")
    with pytest.raises(ProblemInvalid, match="floating"):
        domain_of(window, window.group("body"), RegionOptions())
    street = bundled_world("parallel_parking")
    with pytest.raises(ProblemInvalid, match="cannot follow"):
        domain_of(street, street.group("car"), RegionOptions())


def test_a_plan_of_what_can_have_no_regions_does_not_ask_for_them():
    window = bundled_world("window_3d")
    goal = ConfigurationGoal(next(iter(window.configurations(window.group("body")))))
    problem = PlanningProblem("body", goal, search=SearchOptions(planner="GCS"))
    with pytest.raises(ProblemInvalid, match="floating"):
        pipeline.plan(problem, window, deadline=no_hurry(30.0))


def test_planners_are_listed_with_gcs():
    cards = {card.name: card for card in list_planners()}
    assert list(cards) == sorted(cards)
    assert [name for name, card in cards.items() if card.needs_regions] == ["GCS"]
    assert {parameter.name for parameter in cards["GCS"].parameters} == {
        "max_regions",
        "max_rounded_paths",
    }
