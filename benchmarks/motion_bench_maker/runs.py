"""Plan every problem, time it, and let the referee judge what is delivered."""

import gc
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Literal, Protocol

import numpy as np

import planning
from benchmarks.motion_bench_maker.limits import least_duration, peak_rate
from benchmarks.motion_bench_maker.loads import Load, retime_options
from benchmarks.motion_bench_maker.problems import Problem
from benchmarks.motion_bench_maker.referee import Polynomials, Referee
from benchmarks.motion_bench_maker.robots import ARM, RobotFiles, scene_of
from planning.errors import PlanningFailure
from planning.refine.motion.motion_objectives import MotionObjectives

ALLOWED_SECONDS = 5.0
# What a plan's timings also tell: all stages, and parts of the search.
_NO_STAGES = {"total", "setup", "solve"}
# The tool's pose is asked for exactly.
_EXACT = np.zeros(3)

type GoalKind = Literal["joint", "pose"]
type Method = Literal["none", "trajopt", "auto", "drake"]


@dataclass(frozen=True)
class Run:
    """One call of plan(), and what came of it.

    Attributes:
        problem: Which.
        goal: What kind of goal was asked for.
        total_ms: Wall time of the call, also of one that failed.
        cpu_ms: Processor time of the call.
        stages_ms: By stage; empty if it failed.
        failure: The code of the failure; "" if it was solved.
        detail: What the failure says.
        length: Of the delivered motion, in joint space [rad].
        duration: Of the delivered motion [s].
        free: Whether the referee finds the delivered motion free, and from start to goal.
        improved: Whether refinement made the delivered motion quicker.
        lower_bound: No motion between its two ends takes less, whatever its way: that of the
            slowest joint at full acceleration and speed [s].
        smoothness: Integral over time of its squared accelerations [rad^2/s^3].
        energy: Integral over time of its squared torques [N^2 m^2 s].
        peak_rate: Of the delivered motion: the largest rate over its limit, see `limits.py`.
        method: Of the refine stage.
        reason: Why that stage did not improve the motion, or used another method's; "" if it did.
        load: What the motion was planned under beside limits of single joints.
    """

    problem: Problem
    goal: GoalKind
    total_ms: float
    cpu_ms: float
    stages_ms: dict[str, float] = field(default_factory=dict[str, float])
    failure: str = ""
    detail: str = ""
    length: float = 0.0
    duration: float = 0.0
    free: bool = False
    improved: bool = False
    lower_bound: float = 0.0
    smoothness: float = 0.0
    energy: float = 0.0
    peak_rate: float = 0.0
    method: Method = "none"
    reason: str = ""
    load: Load = "none"

    @property
    def solved(self) -> bool:
        """Whether a motion was delivered."""
        return not self.failure


@dataclass(frozen=True)
class Runs:
    """What came of some problems.

    Attributes:
        problems: All of them.
        invalid: Those whose start or goal collides in the exact model; they were not planned.
        runs: Of each of the others, one per kind of goal and method.
        load_ms: Time to load each world, counted nowhere else.
        others: Runs of other planners on the same problems in turns, by their names.
        reload_ms: Time to load each problem's world but the first, where the one before is there.
    """

    problems: list[Problem]
    invalid: list[Problem]
    runs: list[Run]
    load_ms: list[float]
    others: dict[str, list[Run]] = field(default_factory=dict[str, list[Run]])
    reload_ms: list[float] = field(default_factory=list[float])

    def of_method(self, method: Method) -> "Runs":
        """Return the same with the runs of one method alone."""
        return replace(self, runs=[run for run in self.runs if run.method == method])

    def of_load(self, load: Load) -> "Runs":
        """Return the same with the runs under one load alone."""
        return replace(self, runs=[run for run in self.runs if run.load == load])


class Peer(Protocol):
    """Another planner, with some settings."""

    @property
    def name(self) -> str:
        """What its rows are called."""
        ...

    def run(self, problem: Problem, goal: GoalKind, referee: Referee) -> Run:
        """Plan a problem and let the referee judge what is delivered."""
        ...


@dataclass(frozen=True)
class Bench:
    """What is the same for all problems.

    Attributes:
        files: The robot of the data, for the referee.
        library: The same robot, for the planner.
        methods: Of the refine stage; each plans every problem, one after another.
        clock: Monotonic seconds: by it plans are timed, and have the time that they are allowed.
        objective: What methods other than "none" minimize; None for the duration.
        peers: Plan every problem too, after ours.
        loads: Under each of these every method plans.
    """

    files: RobotFiles
    library: planning.ModelLibrary
    methods: tuple[Method, ...]
    clock: Callable[[], float] = time.monotonic
    objective: planning.RefineObjective | None = None
    peers: tuple[Peer, ...] = ()
    loads: tuple[Load, ...] = ("none",)

    def load(
        self, problem: Problem, *, kernel: bool, previous: planning.World | None = None
    ) -> planning.World:
        """Return the problem's world, with or without the native kernel."""
        scene = scene_of(problem, self.files.spec)
        return planning.load_world(scene, self.library, kernel=kernel, previous=previous)

    def run_all(
        self, problems: Iterable[Problem], goals: tuple[GoalKind, ...], *, kernel: bool
    ) -> Runs:
        """Plan every valid problem, once per kind of goal, method and load."""
        done = Runs(list(problems), [], [], [])
        before: planning.World | None = None
        for problem in done.problems:
            referee = Referee(self.files, problem)
            if not referee.is_valid:
                done.invalid.append(problem)
                continue
            before = self._reload(problem, before, done, kernel=kernel)
            for goal, method, load in product(goals, self.methods, self.loads):
                began = self.clock()
                world = self.load(problem, kernel=kernel)
                done.load_ms.append(1e3 * (self.clock() - began))
                # Else a plan now and then pays for the worlds of ten problems before it, which
                # Python finds unused in its midst: a millisecond each.
                gc.collect()
                query = self._query(problem, self._goal(problem, goal, referee), method, load)
                run = self._run(problem, goal, world, referee, query)
                done.runs.append(replace(run, method=method, load=load))
            for goal, peer in product(goals, self.peers):
                theirs = peer.run(problem, goal, referee)
                done.others.setdefault(peer.name, []).append(theirs)
        return done

    def _reload(
        self, problem: Problem, before: planning.World | None, done: Runs, *, kernel: bool
    ) -> planning.World:
        """Load a problem's world with that of the problem before, and note how long it takes."""
        gc.collect()
        began = self.clock()
        world = self.load(problem, kernel=kernel, previous=before)
        if before is not None:
            done.reload_ms.append(1e3 * (self.clock() - began))
        return world

    def _query(
        self,
        problem: Problem,
        goal: planning.JointGoal | planning.PoseGoal,
        method: Method,
        load: Load,
    ) -> planning.PlanningProblem:
        objective = None if method == "none" else self.objective
        return planning.PlanningProblem(
            f"robot::{ARM}",
            goal,
            start=np.array(problem.start),
            search=planning.SearchOptions(allowed_planning_time=ALLOWED_SECONDS),
            refine=planning.RefineOptions(method, objective=objective),
            retime=retime_options(self.files.spec, load),
        )

    def _run(
        self,
        problem: Problem,
        goal: GoalKind,
        world: planning.World,
        referee: Referee,
        query: planning.PlanningProblem,
    ) -> Run:
        failure, detail, plan = "", "", None
        cpu, began = time.process_time(), self.clock()
        deadline = planning.Deadline.after(ALLOWED_SECONDS, self.clock)
        try:
            plan = planning.plan(query, world, deadline=deadline)
        except PlanningFailure as fault:
            failure, detail = fault.code, fault.detail
        total = 1e3 * (self.clock() - began)
        cpu = 1e3 * (time.process_time() - cpu)
        if plan is None:
            return Run(problem, goal, total, cpu, failure=failure, detail=detail)
        motion = polynomials_of(plan)
        limits = world.limits(plan.group)
        samples = motion.samples()
        costs = MotionObjectives.of(world, plan.group, plan.trajectory, None, None).values()
        return Run(
            problem,
            goal,
            total,
            cpu,
            stages_ms={s: 1e3 * t for s, t in plan.timings.items() if s not in _NO_STAGES},
            length=float(np.linalg.norm(np.diff(samples, axis=0), axis=1).sum()),
            duration=plan.trajectory.duration,
            free=referee.is_free(motion)
            and referee.is_from_start_to_goal(motion, pose=goal == "pose"),
            improved=plan.stages.refine.improved,
            lower_bound=least_duration(
                samples[-1] - samples[0],
                limits.velocity,
                limits.acceleration,
                limits.jerk if self.files.spec.jerk else None,
            ),
            smoothness=costs.smoothness or 0.0,
            energy=costs.energy or 0.0,
            peak_rate=peak_rate(motion, limits.velocity, limits.acceleration),
            reason=plan.stages.refine.reason,
        )

    def _goal(
        self, problem: Problem, goal: GoalKind, referee: Referee
    ) -> planning.JointGoal | planning.PoseGoal:
        if goal == "joint":
            return planning.JointGoal(np.array([problem.goal]))
        target = planning.PoseTarget(planning.Pose.from_matrix(referee.goal_pose))
        return planning.PoseGoal((target,), f"robot::{self.files.spec.tool}", _EXACT, _EXACT)


def polynomials_of(plan: planning.MotionPlan) -> Polynomials:
    """Return the numbers of a delivered trajectory."""
    curve = plan.trajectory
    joints = tuple(joint.name.partition("::")[2] for joint in curve.joints)
    return Polynomials(joints, curve.breaks, curve.bases, curve.coefficients)


def row_name(method: Method, load: Load) -> str:
    """Return the name of a method under a load."""
    return method if load == "none" else f"{method}, {load}"


def by_set(runs: Iterable[Run]) -> Iterator[tuple[str, list[Run]]]:
    """Yield the runs of each set, in the order of their first."""
    groups: dict[str, list[Run]] = {}
    for run in runs:
        groups.setdefault(run.problem.set, []).append(run)
    yield from groups.items()
