"""Planner parameters by OMPL's names: their types, ranges and setters.

OMPL's wheel does not bind `ParamSet`, but a planner prints its declared parameters with their
values, and its setters are bound. A declared `goal_bias` belongs to `setGoalBias`; a table has the
few names that differ. Ranges are those that OMPL's `declareParam` suggests.
"""

import math
from collections.abc import Mapping
from typing import Any, Literal

from planning.errors import ProblemInvalid, UnknownName

type Scalar = str | float | int | bool
type Number = bool | int | float

# Setters whose names do not follow from those of their parameters.
_SETTERS = {
    "cache_cc": ("CacheCC",),
    "delay_collision_checking": ("DelayCC",),
    "drop_unconnected_samples_on_prune": ("DropSamplesOnPrune",),
    "extended_fmt": ("ExtendedFMT",),
    "failed_expansion_score_factor": ("FailedExpansionCellScoreFactor",),
    "find_approximate_solutions": ("ConsiderApproximateSolutions",),
    "number_sampling_attempts": ("NumSamplingAttempts",),
    "ordering_batch_size": ("BatchSize",),
    "prune_threshold_as_fractional_cost_change": ("PruneThresholdFraction",),
    "stop_on_each_solution_improvement": ("StopOnSolnImprovement",),
    "use_admissible_heuristic": ("AdmissibleCostToCome",),
    "use_graph_pruning": ("Pruning",),
    "use_just_in_time_sampling": ("JustInTimeSampling",),
    "use_k_nearest": ("UseKNearest", "KNearest", "NearestK"),
}

_FRACTION = (0.0, 1.0)
_RANGES: dict[str, tuple[float, float]] = {
    "border_fraction": _FRACTION,
    "failed_expansion_score_factor": _FRACTION,
    "goal_bias": _FRACTION,
    "max_nearest_neighbors": (1, 1000),
    "min_valid_path_fraction": _FRACTION,
    "num_samples": (10, 1_000_000),
    "number_sampling_attempts": (10, 100_000),
    "ordering_batch_size": (1, 1_000_000),
    "prune_threshold": _FRACTION,
    "prune_threshold_as_fractional_cost_change": _FRACTION,
    "radius_multiplier": (0.1, 50.0),
    "range": (0.0, 10_000.0),
    "rewire_factor": (1.0, 3.0),
    "samples_per_batch": (1, 1_000_000),
}
_DEFAULT_RANGE = (0.0, math.inf)

# Declared parameters that are not offered (OMPL 2.0.1).
_EXCLUDED = {
    # further sampling after a failure crashes the process if there is no solution
    ("BFMT", "extended_fmt"),
    # without effect any more, by OMPL's documentation
    ("BITstar", "delay_rewiring_to_first_solution"),
    ("BITstar", "use_strict_queue_ordering"),
}

_BOOLEAN_WORDS = {"true": True, "1": True, "false": False, "0": False}


def declared_parameters(planner: Any) -> dict[str, str]:
    """Return the settable parameters of an OMPL planner and their setters' names, sorted."""
    lines = planner.printSettings().splitlines()[1:]
    names = [line.partition("=")[0].strip() for line in lines if "=" in line]
    setters = (
        {name: _setter_name(planner, name) for name in names}
        if names
        else _undeclared_parameters(planner)
    )
    kind = type(planner).__name__
    return {
        name: setter
        for name, setter in sorted(setters.items())
        if setter is not None and (kind, name) not in _EXCLUDED
    }


def value_of(planner: Any, setter: str) -> Number:
    """Return the present value of a parameter."""
    return getattr(planner, f"get{setter}")()


def json_type(value: Number) -> Literal["boolean", "integer", "number"]:
    """Return the JSON type of a parameter's values."""
    if isinstance(value, bool):
        return "boolean"
    return "integer" if isinstance(value, int) else "number"


def range_of(name: str, value: Number) -> tuple[float | None, float | None]:
    """Return the least and the greatest value of a parameter, None for no bound."""
    if isinstance(value, bool):
        return None, None
    low, high = _RANGES.get(name, _DEFAULT_RANGE)
    return low, None if math.isinf(high) else high


def describe_range(name: str, value: Number) -> str:
    """Return the admissible values of a parameter as text."""
    kind = json_type(value)
    if kind == "boolean":
        return "true or false"
    low, high = _RANGES.get(name, _DEFAULT_RANGE)
    return f"{kind}, at least {low:.9g}" + ("" if math.isinf(high) else f", at most {high:.9g}")


def set_parameters(planner: Any, parameters: Mapping[str, Scalar]) -> None:
    """Set parameters of an OMPL planner.

    Raises:
        UnknownName: The planner has no such parameter.
        ProblemInvalid: A value has the wrong type or lies outside its range.
    """
    setters = declared_parameters(planner)
    for name, given in sorted(parameters.items()):
        if name not in setters:
            raise UnknownName.among("parameter", name, setters)
        setter = setters[name]
        current = value_of(planner, setter)
        value = _convert(given, current)
        if value is not None and value == current:
            # A default may lie outside of the range, where it stands for the planner's own choice.
            continue
        if value is None or not _is_in_range(name, value):
            raise ProblemInvalid(
                f"parameter {name!r} of {type(planner).__name__} is {given!r}; "
                f"it must be: {describe_range(name, current)}",
                {
                    "field": f"search.parameters.{name}",
                    "value": str(given),
                    "range": describe_range(name, current),
                },
            )
        if not _try_set(planner, setter, value):
            raise ProblemInvalid(
                f"{type(planner).__name__} refuses parameter {name!r} = {given!r} together with "
                "its other parameters",
                {"field": f"search.parameters.{name}", "value": str(given)},
            )


def _try_set(planner: Any, setter: str, value: Number) -> bool:
    """Return whether OMPL takes the value; it may reject a combination by an error or silently."""
    try:
        getattr(planner, f"set{setter}")(value)
    except RuntimeError:  # the binding's translation of OMPL's exceptions
        return False
    return value_of(planner, setter) == value


def _setter_name(planner: Any, name: str) -> str | None:
    """Return X for a declared parameter with the setter setX and the getter getX."""
    regular = "".join(word.capitalize() for word in name.split("_"))
    for candidate in (regular, *_SETTERS.get(name, ())):
        if hasattr(planner, f"set{candidate}") and hasattr(planner, f"get{candidate}"):
            return candidate
    return None


def _undeclared_parameters(planner: Any) -> dict[str, str | None]:
    """Return settable parameters of a planner that declares none."""
    setters: dict[str, str | None] = {}
    for method in dir(planner):
        setter = method.removeprefix("set")
        if method == setter or not hasattr(planner, f"get{setter}"):
            continue
        value = getattr(planner, f"get{setter}")()
        if isinstance(value, bool | int | float):
            # PRMstar fixes the number of neighbours itself and refuses any other.
            if not _try_set(planner, setter, value):
                continue
            setters["".join(f"_{c.lower()}" if c.isupper() else c for c in setter)[1:]] = setter
    return setters


def _convert(given: Scalar, current: Number) -> Number | None:
    """Return the given value in the type of the present one, or None if that is impossible."""
    if isinstance(current, bool):
        return given if isinstance(given, bool) else _BOOLEAN_WORDS.get(str(given).lower())
    if isinstance(given, bool):
        return None
    try:
        number = float(given)
    except ValueError:
        return None
    if not math.isfinite(number):
        return None
    if isinstance(current, int):
        return int(number) if number.is_integer() else None
    return number


def _is_in_range(name: str, value: Number) -> bool:
    low, high = _RANGES.get(name, _DEFAULT_RANGE)
    return isinstance(value, bool) or low <= value <= high
