"""Whenever the deadline comes, a plan is whole, or it fails typed, in a stage that it names.

Time is looks at the clock: how many there are after the deadline is how late a plan may be.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import planning
from planning.domain.curves.path import JointPath
from planning.domain.geometry.pose import Pose
from planning.domain.goals.goal import ConfigurationGoal, Goal, PoseGoal, PoseTarget
from planning.domain.report.motion_plan import MotionPlan, Progress
from planning.domain.request.constraint import OrientationCone
from planning.domain.request.deadline import Deadline
from planning.domain.request.motion_limits import ToolLimit
from planning.domain.request.options import (
    CertifyOptions,
    IkOptions,
    RefineOptions,
    RetimeOptions,
    RoadmapOptions,
    SearchOptions,
)
from planning.domain.request.problem import PlanningProblem
from planning.domain.robot.joints import JointType
from planning.errors import DeadlineExceeded, GoalUnreachable, PlanningFailure
from planning.pipeline.timing.path_curves import collision_free_curves
from planning.retime.retimer import RETIMERS
from tests.clocks import FakeClock, after_looks, no_hurry
from tests.conftest import bundled_world, group_of
from tests.profiles import PROFILE, num_cases, rng_of, seeds

STAGES = ("goals", "roadmap", "search", "refine", "retime", "certify", "explain")
# Looks at the clock after the deadline: to close stages, and what a failure does to say why.
MOST_LOOKS = 24
ALLOWED = 1.0
# What the time runs out in does not matter to plans that come after it.
FAST = SearchOptions(allowed_planning_time=1e9)
RUCKIG = RetimeOptions("ruckig", explain=True)
PLAIN = RefineOptions("none")


def to_frame(frame: str, **legs: Any) -> PoseGoal:
    return PoseGoal((PoseTarget(Pose.identity(), frame),), "", np.zeros(3), np.zeros(3), **legs)


def asked(group: str, goal: Goal, **options: Any) -> PlanningProblem:
    return PlanningProblem(group, goal, **{"search": FAST, "seed": 1, **options})


def cases() -> dict[str, tuple[str, PlanningProblem]]:
    down = OrientationCone("arm::tcp", np.array([0, 0, 1.0]), np.array([0, 0, -1.0]), 3.0)
    limited = replace(RUCKIG, effort=True, tool_limits=(ToolLimit("arm::tcp", 0.3, 1.0),))
    slow_tool = replace(RUCKIG, tool_limits=limited.tool_limits)
    ready, away = ConfigurationGoal("ready"), np.array([0, 0, -0.03])
    few = replace(FAST, roadmap=RoadmapOptions(states=200, neighbours=5))
    return {
        "jerk": ("ur5e_pickup", asked("arm", to_frame("place"), retime=RUCKIG, refine=PLAIN)),
        "refined": ("ur5e_pickup", asked("arm", to_frame("pick"))),
        "legs": ("ur5e_pickup", asked("arm", to_frame("pick", approach=away), refine=PLAIN)),
        "limits": ("ur5e_pickup", asked("arm", ready, retime=limited, refine=PLAIN)),
        "stops": (
            "ur5e_pickup",
            asked("arm", ready, certify=CertifyOptions(max_stopping_time=9.0), refine=PLAIN),
        ),
        "cone": ("ur5e_pickup", asked("arm", ready, constraints=(down,), refine=PLAIN)),
        "roadmap": ("maze_2d", asked("body", ConfigurationGoal("exit"), search=few, refine=PLAIN)),
        "maze": ("maze_2d", asked("body", ConfigurationGoal("exit"), refine=PLAIN)),
        "tool": ("ur5e_pickup", asked("arm", to_frame("place"), retime=slow_tool, refine=PLAIN)),
    }


@dataclass
class Hurry:
    """Time that stands still until a stage begins, and then runs out after some looks.

    Attributes:
        until: The stage with which it stands still again, if it has not run out.
    """

    stage: str
    looks: int
    until: str = ""
    clock: FakeClock = field(default_factory=FakeClock)
    seen: list[str] = field(default_factory=list)

    def note(self, progress: Progress) -> None:
        if progress.stage not in self.seen:
            self.seen.append(progress.stage)
        if progress.stage == self.stage and not self.clock.step:
            self.clock.step = ALLOWED / self.looks
        elif progress.stage == self.until:
            self.clock.step = 0.0

    @property
    def deadline(self) -> Deadline:
        return Deadline(ALLOWED, ALLOWED, self.clock)

    @property
    def late(self) -> float:
        """Looks after the deadline."""
        return (self.clock.now - ALLOWED) / self.clock.step if self.clock.step else 0.0


@cache
def whole(name: str) -> tuple[MotionPlan, tuple[str, ...]]:
    """The plan that no deadline cuts, and its stages."""
    scene, problem = cases()[name]
    hurry = Hurry("", 1)
    found = planning.plan(
        problem, bundled_world(scene), deadline=hurry.deadline, on_progress=hurry.note
    )
    assert found.cut_short == ()
    return found, tuple(hurry.seen)


def hurried(name: str, hurry: Hurry) -> MotionPlan | PlanningFailure:
    scene, problem = cases()[name]
    try:
        return planning.plan(
            problem, bundled_world(scene), deadline=hurry.deadline, on_progress=hurry.note
        )
    except PlanningFailure as failure:
        return failure


def are_told(timings: dict[str, float]) -> bool:
    """Whether stages and their sum are there, none negative."""
    within = [seconds for name, seconds in timings.items() if name in STAGES]
    return min(timings.values()) >= 0 and sum(within) <= timings["total"] + 1e-9


@pytest.mark.campaign
@pytest.mark.parametrize("name", list(cases())[:: num_cases(2, 1)])
def test_a_plan_is_whole_or_fails_in_a_stage_that_it_names(name: str) -> None:
    plan, stages = whole(name)
    assert set(stages) <= set(STAGES)
    # Every other stage, if there are to be few.
    some = stages if PROFILE.is_campaign else stages[list(cases()).index(name) // 2 % 2 :: 2]
    for stage in some:
        for seed in seeds(1, 6):
            looks = int(np.exp(rng_of(seed).uniform(0, np.log(40))))
            outcome = hurried(name, hurry := Hurry(stage, looks))
            told = f"{stage} after {looks}: {outcome!r}"
            assert hurry.late <= MOST_LOOKS, told
            if isinstance(outcome, MotionPlan):
                assert outcome.certificate.proven, told
                assert outcome.cut_short or outcome.digest == plan.digest, told
            else:
                assert isinstance(outcome, DeadlineExceeded), told
                # What is not proven is searched for again.
                assert STAGES.index(outcome.stage) >= min(STAGES.index(stage), 2), told
                assert outcome.stage in outcome.timings, told
                assert are_told(outcome.timings), told


@dataclass
class Gaps:
    """Time on the processor, and the longest from one look at it to the next."""

    last: float = field(default_factory=time.thread_time)
    longest: float = 0.0

    def __call__(self) -> float:
        now = time.thread_time()
        self.longest, self.last = max(self.longest, now - self.last), now
        return 0.0


@pytest.mark.parametrize("name", ["jerk", "limits", "stops"][: num_cases(2, 3)])
def test_no_stage_forgets_the_clock_for_long(name: str) -> None:
    whole(name)  # what is made once is made
    scene, problem = cases()[name]
    robust = replace(problem.certify, robustness=True)
    gaps = Gaps()
    began = gaps.last
    planning.plan(
        replace(problem, certify=robust), bundled_world(scene), deadline=Deadline.after(9.0, gaps)
    )
    gaps()
    assert gaps.longest < 0.2 * (gaps.last - began)


def near_home(count: int) -> np.ndarray:
    """Return waypoints about a configuration, with a corner at each."""
    world = bundled_world("ur5e_pickup")
    return world.positions(world.group("arm")) + rng_of(0).uniform(-0.05, 0.05, (count, 6))


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
def test_a_path_of_many_waypoints_looks_at_the_clock(method: Any) -> None:
    whole("jerk")  # what is made once is made
    gaps = Gaps()
    began = gaps.last
    planning.retime_path(
        bundled_world("ur5e_pickup"),
        "arm",
        near_home(1_000),
        deadline=Deadline.after(9.0, gaps),
        options=RetimeOptions(method),
    )
    gaps()
    assert gaps.longest < 0.5 * (gaps.last - began)


def test_no_piece_is_put_together_after_the_deadline(monkeypatch: pytest.MonkeyPatch) -> None:
    """What follows the profile of a piece takes as long as the profile itself."""
    clock, known = FakeClock(), RETIMERS["toppra"]

    def late(*arguments: Any) -> Any:
        profile = known.profile(*arguments)
        clock.advance(2 * ALLOWED)
        return profile

    monkeypatch.setitem(RETIMERS, "toppra", replace(known, profile=late, timed_at_once=None))
    with pytest.raises(DeadlineExceeded) as caught:
        planning.retime_path(
            bundled_world("ur5e_pickup"), "arm", near_home(3), deadline=Deadline.after(1.0, clock)
        )
    assert caught.value.stage == "retime"


@dataclass
class Counting:
    """Checker for which all is free, and the number of configurations of each of its calls."""

    batches: list[int] = field(default_factory=list)

    def are_free(self, qs: np.ndarray) -> np.ndarray:
        self.batches.append(len(qs))
        return np.ones(len(qs), dtype=bool)


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
def test_a_way_of_kilometres_is_not_checked_in_one_breath(method: Any) -> None:
    group = group_of(JointType.PRISMATIC)
    checker: Any = Counting()
    path = JointPath(group, np.array([[0.0], [1e4], [0.0], [5e3]]))
    curves = collision_free_curves(path, RetimeOptions(method), checker, None, after_looks(5))
    with pytest.raises(DeadlineExceeded) as caught:
        list(curves)
    assert caught.value.stage == "retime"
    assert max(checker.batches) <= 2_000
    assert sum(checker.batches) <= 20_000


@pytest.mark.parametrize(
    ("name", "stage", "looks"),
    [
        ("legs", "goals", 5),
        ("roadmap", "roadmap", 5),
        ("jerk", "search", 1),
        ("jerk", "retime", 1),
        ("jerk", "certify", 1),
    ],
)
def test_the_stage_at_work_is_the_one_that_fails(name: str, stage: str, looks: int) -> None:
    outcome = hurried(name, Hurry(stage, looks))
    assert isinstance(outcome, DeadlineExceeded)
    assert (outcome.stage, outcome.evidence["allowed"]) == (stage, ALLOWED)
    assert list(outcome.timings)[-1] == "total"


def test_a_motion_is_not_lost_for_one_that_may_be_quicker() -> None:
    tried = (hurried("tool", Hurry("retime", looks, until="certify")) for looks in range(10, 80))
    found = next(plan for plan in tried if isinstance(plan, MotionPlan))
    assert found.certificate.proven
    assert found.cut_short == ("retime",)


@pytest.mark.parametrize("looks", [1, 2, 9])
def test_an_explanation_is_cut_and_the_motion_is_kept(looks: int) -> None:
    plan, stages = whole("jerk")
    assert stages[-1] == "explain"
    assert plan.stages.retime.explanation is not None
    found = hurried("jerk", Hurry("explain", looks))
    assert isinstance(found, MotionPlan)
    assert (found.cut_short, found.stages.retime.explanation) == (("explain",), None)
    assert found.digest == plan.digest
    assert "explain" in found.timings


@pytest.mark.parametrize("looks", [1, 12])
def test_a_bound_that_was_only_asked_for_is_cut_and_one_that_must_hold_is_not(looks: int) -> None:
    stops, name = CertifyOptions(stop_anywhere=True, robustness=True), "stops"
    scene, problem = cases()[name]
    hurry = Hurry("certify", 30 + looks)
    found = planning.plan(
        replace(problem, certify=stops),
        bundled_world(scene),
        deadline=hurry.deadline,
        on_progress=hurry.note,
    )
    assert found.certificate.proven
    assert (found.cut_short, found.stages.certify.robustness) == (("certify",), None)
    outcome = hurried(name, Hurry("certify", 30 + looks))
    assert isinstance(outcome, DeadlineExceeded)
    assert outcome.stage == "certify"


def test_refinement_that_is_cut_is_told() -> None:
    found = hurried("refined", Hurry("refine", 7, until="retime"))
    assert isinstance(found, MotionPlan)
    assert found.certificate.proven
    assert found.cut_short == ("refine",)


def test_who_asks_for_no_shortcuts_has_none_cut() -> None:
    scene, problem = cases()["maze"]
    search = replace(FAST, shortcut_time=0.0)
    found = planning.plan(
        replace(problem, search=search), bundled_world(scene), deadline=no_hurry()
    )
    assert found.cut_short == ()


def test_a_plan_keeps_the_time_that_its_problem_allows() -> None:
    scene, problem = cases()["maze"]
    clock = FakeClock(step=1e-3)
    search = replace(FAST, allowed_planning_time=0.02)
    with pytest.raises(DeadlineExceeded) as caught:
        planning.plan(
            replace(problem, search=search),
            bundled_world(scene),
            deadline=Deadline.after(60.0, clock),
        )
    assert caught.value.evidence["allowed"] == 0.02
    assert clock.now < 0.02 + MOST_LOOKS * clock.step


def test_other_failures_keep_their_timings_too() -> None:
    goal = PoseGoal((PoseTarget(Pose.from_parts([9, 0, 0])),), "", np.zeros(3), np.zeros(3))
    problem = asked("arm", goal, ik=IkOptions(max_trials=3))
    with pytest.raises(GoalUnreachable) as caught:
        planning.plan(problem, bundled_world("ur5e_pickup"), deadline=after_looks(40))
    assert set(caught.value.timings) == {"goals", "total"}
    assert caught.value.timings["goals"] > 0


def operations() -> dict[str, tuple[str, Callable[[Deadline], Any]]]:
    """What else has a deadline, and the stages that it may run out in."""
    world = bundled_world("ur5e_pickup")
    motion = whole("jerk")[0]
    mid, rows = motion.trajectory.duration / 2, motion.path.waypoints
    problem = cases()["stops"][1]
    few = replace(FAST, roadmap=RoadmapOptions(states=200, neighbours=5))
    wanted, smooth = CertifyOptions(max_stopping_time=9.0), RetimeOptions("ruckig")
    running = world, "arm", motion.trajectory, mid
    return {
        "retime": (
            "retime certify",
            lambda d: planning.retime_path(
                world, "arm", rows, deadline=d, options=RUCKIG, certify_options=wanted
            ),
        ),
        "certify": (
            "certify",
            lambda d: planning.certify_trajectory(
                world, "arm", motion.trajectory, deadline=d, options=smooth, certify_options=wanted
            ),
        ),
        "reverse": (
            "certify",
            lambda d: planning.reverse_plan(
                world, problem, motion.path, motion.trajectory, motion.parts, d
            ),
        ),
        "stop": ("retime certify", lambda d: planning.stop_motion(*running, deadline=d)),
        "stop along": (
            "retime certify",
            lambda d: planning.stop_motion(*running, deadline=d, options=smooth, along_path=True),
        ),
        "splice": (
            "retime certify",
            lambda d: planning.splice_motion(
                *running, motion.trajectory.reverse, deadline=d, options=smooth
            ),
        ),
        "ik": ("goals", lambda d: planning.solve_ik(world, "arm", to_frame("pick"), deadline=d)),
        "line": (
            "line",
            lambda d: planning.trace_line(
                world, "arm", PoseTarget(Pose.identity(), "pick"), deadline=d
            ),
        ),
        "roadmap": (
            "roadmap",
            lambda d: planning.build_roadmap(replace(problem, search=few), world, deadline=d),
        ),
    }


@pytest.mark.campaign
@pytest.mark.parametrize(
    "name",
    ["retime", "certify", "reverse", "stop", "stop along", "splice", "ik", "line", "roadmap"],
)
def test_an_operation_of_its_own_ends_in_time_and_says_where(name: str) -> None:
    stages, operation = operations()[name]
    for looks in (1, 3, *(int(rng_of(seed).integers(4, 60)) for seed in seeds(1, 20))):
        deadline = after_looks(looks)
        failure = None
        try:
            operation(deadline)
        except DeadlineExceeded as late:
            failure = late
        if failure is not None:
            assert failure.stage in stages.split(), (looks, failure.stage)
            assert failure.stage in failure.timings, (looks, failure.timings)
        clock = deadline.clock
        assert isinstance(clock, FakeClock)
        assert (clock.now - deadline.expires_at) / clock.step <= MOST_LOOKS, looks


def test_regions_stop_growing_in_time() -> None:
    for looks in range(1, 2 + num_cases(4)):
        deadline = after_looks(looks)
        found = planning.grow_regions(bundled_world("maze_2d"), "body", deadline=deadline)
        assert found.stopped_by == "deadline"
