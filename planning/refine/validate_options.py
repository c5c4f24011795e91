"""validate_refinement(): which options of refinement go together, and what each method can do."""

from planning.domain.goals.goal import Goal, LineGoal, PoseGoal, RegionGoal
from planning.domain.request.options import RefineOptions
from planning.domain.request.refine_objective import (
    DERIVATIVES,
    MAX_DURATION,
    MAX_WEIGHT,
    RefineObjective,
)
from planning.domain.robot.joints import JointGroup
from planning.domain.robot.manifold import Manifold
from planning.domain.robot.steering import steering_of
from planning.errors import ProblemInvalid, UnknownName
from planning.refine.constraints.clearance_objective import validate_clearance_objective


def validate_refinement(
    options: RefineOptions, group: JointGroup, goal: Goal, duration: float | None = None
) -> None:
    """Check the options of a request's refinement.

    Args:
        options: The options.
        group: The group that moves.
        goal: Its goal.
        duration: Requested duration of the whole motion [s]; None for the least.

    Raises:
        ProblemInvalid: A number is invalid, or the method cannot do what is asked.
        UnknownName: There is no such derivative.
    """
    validate_clearance_objective(options)
    if options.method == "drake" and options.clearance is not None:
        raise _invalid("clearance", "method 'drake' keeps margins, but weighs no clearance")
    if options.method == "drake" and steering_of(group):
        raise _invalid("method", "drake's splines do not keep the steering of a car")
    if options.objective is not None:
        _validate_objective(options, options.objective, group)
        fault = options.objective.fault_beside(goal, duration)
        if fault:
            raise _invalid("objective", fault)
    if options.terms:
        _validate_terms(options, group, goal)


def _validate_objective(
    options: RefineOptions, objective: RefineObjective, group: JointGroup
) -> None:
    _validate_values(objective)
    fault = objective.fault_with(options.method)
    if not fault and options.clearance is not None:
        fault = "clearance is weighed against the duration in seconds; leave one of the two out"
    if not fault and steering_of(group) and not objective.is_duration_alone:
        fault = f"{group.name!r} has a car: of its drives only the duration is optimized"
    if not fault and objective.energy and not Manifold(group.joints).is_flat:
        fault = f"the energy of {group.name!r} is not known: a joint of it floats"
    if fault:
        raise _invalid("objective", fault)


def _validate_values(objective: RefineObjective) -> None:
    for name, weight in objective.weights.items():
        if not 0 <= weight <= MAX_WEIGHT:
            rule = f"it must be finite and not negative, at most {MAX_WEIGHT:g}"
            raise _invalid(f"objective.{name}", rule)
    if objective.derivative not in DERIVATIVES:
        raise UnknownName.among("derivative", objective.derivative, DERIVATIVES)
    longest = objective.max_duration
    if longest is not None and not 0 < longest <= MAX_DURATION:
        rule = f"it must be positive and finite, at most {MAX_DURATION:g} s"
        raise _invalid("objective.max_duration", rule)


def _validate_terms(options: RefineOptions, group: JointGroup, goal: Goal) -> None:
    if options.method != "drake":
        raise _invalid("terms", f"they require method 'drake', not {options.method!r}")
    if not Manifold(group.joints).is_flat:
        raise _invalid("terms", f"a joint of {group.name!r} floats")
    if isinstance(goal, LineGoal):
        raise _invalid("terms", "goals along lines are not optimized")
    if isinstance(goal, PoseGoal | RegionGoal) and _has_linear_moves(goal):
        raise _invalid("terms", "they cannot be checked beside an approach or a retreat")


def _has_linear_moves(goal: PoseGoal | RegionGoal) -> bool:
    return goal.approach is not None or goal.retreat is not None


def _invalid(field: str, message: str) -> ProblemInvalid:
    field = f"refine.{field}"
    return ProblemInvalid(f"{field}: {message}", {"field": field})
