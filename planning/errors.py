"""Errors of Wayproof: every failure is a class with a stable code and evidence.

WayproofError                 code, detail, evidence; pickles, so it crosses processes
├── InputError                the request is invalid; nothing was computed
│   ├── SceneInvalid          scene_invalid          a scene document with a fault, and where
│   ├── SceneEditImpossible   scene_edit_impossible  an operation that does not apply to this scene
│   ├── AssetNotFound         asset_not_found        a robot or mesh file that does not exist
│   ├── ModelInvalid          model_invalid          a robot file that is unsafe or does not load
│   ├── ProblemInvalid        problem_invalid        wrong counts, NaN, contradictory options
│   └── UnknownName           unknown_name           a name that does not exist, and those that do
└── StageFailure              stage, timings; work was begun and failed
    ├── PlanningFailure       planning was tried and found no motion
    │   ├── StartInCollision      start_in_collision     the pairs and depths at the start
    │   ├── StartTooNear          start_too_near         the pairs and margins at the start
    │   ├── StartOutOfLimits      start_out_of_limits    the joints, values and bounds
    │   ├── GoalOutOfLimits       goal_out_of_limits     the joints, values and bounds
    │   ├── GoalInCollision       goal_in_collision      every goal configuration collides
    │   ├── GoalTooNear           goal_too_near          of some goal only margins are violated
    │   ├── GoalUnreachable       goal_unreachable       the funnel, the nearest pose, a relaxation
    │   ├── StartViolatesConstraint  start_violates_constraint  which constraint, and by how much
    │   ├── GoalViolatesConstraint   goal_violates_constraint   how many violate which; the least
    │   ├── ApproachBlocked       approach_blocked       the funnel, and what stopped the lines
    │   ├── LineBlocked           line_blocked           how far the line goes, and what stops it
    │   ├── NoPathFound           no_path_found          the planner, its attempts and checks
    │   ├── DeadlineExceeded      deadline_exceeded      the time allowed, and the stage at its end
    │   ├── Canceled              canceled               the caller canceled the plan
    │   ├── RetimingFailed        retiming_failed        the retimer and why
    │   ├── NotCertified          not_certified          the checks that failed
    │   └── ScheduleNotFound      schedule_not_found     the motions that meet, the pair, the times
    └── ExecutionFailure      an execution that cannot be carried out
        ├── GraspMissed           grasp_missed           the object, how far each finger is from it
        ├── IllegalTransition     illegal_transition     the state, the event, the legal ones
        ├── TrackingLost          tracking_lost          the error and its bound
        ├── Contact               contact                the pair, the force, the time
        ├── TorqueLimitReached    torque_limit_reached   the joint, its torque and bound, how long
        ├── GraspLost             grasp_lost             the object, how far it slipped, the bound
        ├── PathBlocked           path_blocked           the check, the pair, the time, the revision
        └── DriverLost            driver_lost            the driver, why, whether the robot rests
"""

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from typing import Any, ClassVar, override

type Evidence = Mapping[str, Any]


class WayproofError(Exception):
    """Base class of all errors of Wayproof.

    Attributes:
        code: Stable machine-readable name, unique in the tree.
        detail: One or two sentences for a person.
        evidence: JSON-compatible facts about the failure (SI units, radians).
    """

    code: ClassVar[str] = "error"

    def __init__(self, detail: str, evidence: Evidence | None = None) -> None:
        super().__init__(detail)
        self.detail = detail
        self.evidence: dict[str, Any] = dict(evidence or {})

    @override
    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.detail, self.evidence)


class InputError(WayproofError):
    """The request is invalid; nothing was computed."""


class SceneInvalid(InputError):
    """A scene document has a fault; evidence: `path`, and `line` if it came as text."""

    code = "scene_invalid"


class SceneEditImpossible(InputError):
    """An operation cannot be applied to this scene; evidence: `operation`, and the obstacle."""

    code = "scene_edit_impossible"


class AssetNotFound(InputError):
    """A robot description, mesh or package does not exist; evidence: `uri`, `known`."""

    code = "asset_not_found"


class ModelInvalid(InputError):
    """A robot file is unsafe or does not load; evidence: `file`, `reason`."""

    code = "model_invalid"


class ProblemInvalid(InputError):
    """A planning problem has a fault; evidence: `field`."""

    code = "problem_invalid"


class UnknownName(InputError):
    """A name does not exist; evidence: `kind`, `name`, `known`, `nearest`."""

    code = "unknown_name"

    @classmethod
    def among(cls, kind: str, name: str, known: Iterable[str]) -> "UnknownName":
        """Build the error that names the wrong thing and the right ones."""
        names = sorted(known)  # compared without case: that is misspelt most often
        folded = {known_name.casefold(): known_name for known_name in reversed(names)}
        nearest = [folded[match] for match in get_close_matches(name.casefold(), folded, n=3)]
        hint = f"did you mean {nearest[0]!r}? " if nearest else ""
        several = f"{kind[:-1]}ies" if kind.endswith("dy") else f"{kind}s"  # bodies, but keys
        text = f"{kind} {name!r} does not exist; {hint}{several}: {names}"
        return cls(text, {"kind": kind, "name": name, "known": names, "nearest": nearest})


class StageFailure(WayproofError):
    """Work was begun and failed in one of its stages.

    Attributes:
        stage: The one that failed, or in which the deadline or the cancel ended the work.
        timings: Seconds per stage, with the one that failed; empty where nothing was timed.
    """

    stage: str = ""

    def __init__(self, detail: str, evidence: Evidence | None = None) -> None:
        super().__init__(detail, evidence)
        self.timings: dict[str, float] = {}

    @override
    def __reduce__(self) -> tuple[Any, ...]:
        return *super().__reduce__(), {"stage": self.stage, "timings": self.timings}

    def in_stage[F: "StageFailure"](self: F, stage: str) -> F:  # noqa: PYI019  (no Self: beartype)
        """Return the same failure with its stage set."""
        self.stage = stage
        return self

    def saying[F: "StageFailure"](self: F, detail: str, more: Evidence) -> F:  # noqa: PYI019
        """Return the failure with another detail and more evidence, of the same stage."""
        failure = type(self)(detail, {**self.evidence, **more}).in_stage(self.stage)
        failure.timings = self.timings
        return failure


class PlanningFailure(StageFailure):
    """Planning was tried and found no motion."""

    stage = "plan"


class GoalStageFailure(PlanningFailure):
    """The start or the goal cannot be used, so nothing was searched."""

    stage = "goals"


class StartInCollision(GoalStageFailure):
    """Bodies overlap at the start; evidence: `pairs` with `distance` and `depth` [m]."""

    code = "start_in_collision"


class StartTooNear(GoalStageFailure):
    """The start is free of collision but violates a margin; evidence: as `StartInCollision`."""

    code = "start_too_near"


class StartOutOfLimits(GoalStageFailure):
    """The start violates position limits; evidence: `joints`."""

    code = "start_out_of_limits"


class GoalOutOfLimits(GoalStageFailure):
    """Every goal configuration violates position limits; evidence: `joints`, `nearest`."""

    code = "goal_out_of_limits"


class GoalInCollision(GoalStageFailure):
    """In all goal configurations bodies overlap; evidence: `funnel`, `nearest`, `relaxation`."""

    code = "goal_in_collision"


class GoalTooNear(GoalStageFailure):
    """Some goal configurations are free, none keeps its margins; evidence: as `GoalInCollision`."""

    code = "goal_too_near"


class GoalUnreachable(GoalStageFailure):
    """No configuration reaches the goal; evidence: `funnel`, `nearest`, `relaxation`."""

    code = "goal_unreachable"


class StartViolatesConstraint(GoalStageFailure):
    """The start violates path constraints; evidence: `violations` with `value` and `bound`."""

    code = "start_violates_constraint"


class GoalViolatesConstraint(GoalStageFailure):
    """Every goal configuration violates path constraints; evidence: `violations`, `nearest`, ..."""

    code = "goal_violates_constraint"


class ApproachBlocked(GoalStageFailure):
    """No free goal configuration has a free approach and retreat; evidence: `funnel`, `nearest`."""

    code = "approach_blocked"


class LineBlocked(GoalStageFailure):
    """A straight line stops before its end; evidence: `line` (from 0), `fraction`, `stopped_by`."""

    code = "line_blocked"


class NoPathFound(PlanningFailure):
    """The planner ended without an exact solution; evidence: its report."""

    code = "no_path_found"
    stage = "search"


class DeadlineExceeded(PlanningFailure):
    """The allowed time ran out in the stage that was running; evidence: `allowed` [s], `during`."""

    code = "deadline_exceeded"
    stage = "search"


class Canceled(PlanningFailure):
    """The caller canceled this plan."""

    code = "canceled"


class RetimingFailed(PlanningFailure):
    """No timing of the path keeps the limits; evidence: `method`, or the `limit` and `where`."""

    code = "retiming_failed"
    stage = "retime"


class NotCertified(PlanningFailure):
    """No candidate motion passed the certifier; evidence: `checks` that failed."""

    code = "not_certified"
    stage = "certify"


class ScheduleNotFound(PlanningFailure):
    """No delays keep several motions apart; evidence: `groups`, `pair`, `time`, `encounters`."""

    code = "schedule_not_found"
    stage = "schedule"


class ExecutionFailure(StageFailure):
    """An execution cannot be carried out as asked, or not to its end."""

    stage = "execute"


class GraspMissed(ExecutionFailure):
    """Fingers that close do not hold the object; evidence: `object`, `width`, `distances`, ..."""

    code = "grasp_missed"


class IllegalTransition(ExecutionFailure):
    """The present state does not allow an event; evidence: `state`, `event`, `legal`."""

    code = "illegal_transition"


class TrackingLost(ExecutionFailure):
    """The robot left the trajectory; evidence: `error`, `bound`, `time`."""

    code = "tracking_lost"


class Contact(ExecutionFailure):
    """The robot touched something; evidence: `pair`, `depth`, `force`, `time`."""

    code = "contact"


class TorqueLimitReached(ExecutionFailure):
    """A joint was at its torque limit for too long; evidence: `joint`, `torque`, `bound`, ..."""

    code = "torque_limit_reached"


class GraspLost(ExecutionFailure):
    """An object slipped out of its gripper; evidence: `object`, `frame`, `slip`, `bound`, ..."""

    code = "grasp_lost"


class PathBlocked(ExecutionFailure):
    """An edit of the scene blocks the rest of the motion; evidence: `check`, `pair`, `time`, ..."""

    code = "path_blocked"


class DriverLost(ExecutionFailure):
    """The robot does not answer, or no longer obeys; evidence: `driver`, `reason`, `rests`."""

    code = "driver_lost"
