"""Planner list: the geometric planners that OMPL's wheel binds, found by inspection of the module.

See `termination` and `prm` for how each of them ends.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any

from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from planning.domain.planner.planner_card import PlannerCard, PlannerParameter
from planning.domain.planner.unavailable_planners import unknown_planner
from planning.errors import UnknownName
from planning.search.ompl.parameters import (
    Scalar,
    declared_parameters,
    describe_range,
    json_type,
    range_of,
    set_parameters,
    value_of,
)

# Default `range` of RRTConnect (joint-space length), unless OMPL chooses a shorter one. OMPL's
# default, a fifth of the space's diagonal, is about 2.6 rad for an arm of seven joints: most
# motions of that length are blocked, in narrow places nearly all. On MotionBenchMaker's Panda
# problems 0.5 took a sixth of the checks, 0.3 and 0.8 a few more than 0.5.
RRT_CONNECT_RANGE = 0.5

# OMPL logs to the terminal by default; our reports and errors contain what matters of it.
ou.setLogLevel(ou.LogLevel.LOG_NONE)


def planner_names() -> list[str]:
    """Return the names of all geometric planners, sorted."""
    return list(_planner_names())


@lru_cache(maxsize=1)
def _planner_names() -> tuple[str, ...]:
    return tuple(sorted(name for name, item in vars(og).items() if _is_planner(item)))


def check_planners(names: Sequence[str], parameters: Mapping[str, Scalar]) -> None:
    """Check that all planners exist, and that each parameter belongs to at least one of them.

    Raises:
        UnknownName: No such planner, or a parameter that none of these has.
        ProblemInvalid: A parameter's value has the wrong type or lies outside its range.
    """
    if len(names) == 1:
        check_planner(names[0], parameters)
        return
    known: set[str] = set()
    for name in names:
        check_planner(name, {})
        known |= _parameter_names(name)
    for parameter in parameters:
        if parameter not in known:
            raise UnknownName.among("parameter", parameter, known)
    for name in names:
        check_planner(name, own_parameters(name, parameters))


def own_parameters(name: str, parameters: Mapping[str, Scalar]) -> dict[str, Scalar]:
    """Return those of the parameters that a planner has."""
    names = _parameter_names(name)
    return {parameter: value for parameter, value in parameters.items() if parameter in names}


@lru_cache(maxsize=32)
def _parameter_names(name: str) -> frozenset[str]:
    return frozenset(
        parameter.name for parameter in _card(_minimal_space_information(), name).parameters
    )


def check_planner(name: str, parameters: Mapping[str, Scalar]) -> None:
    """Check that a planner exists and takes these parameters.

    Raises:
        UnknownName: No planner, or no parameter of this one, has such a name.
        ProblemInvalid: A parameter's value has the wrong type or lies outside its range.
    """
    # True, 1 and 1.0 are equal keys of a cache, but different values to a planner.
    _check_cached(
        name, tuple((key, type(given), given) for key, given in sorted(parameters.items()))
    )


@lru_cache(maxsize=256)
def _check_cached(name: str, parameters: tuple[tuple[str, type, Scalar], ...]) -> None:
    """Make such a planner; only success is cached, errors are raised anew each time."""
    make_planner(_minimal_space_information(), name, {key: given for key, _, given in parameters})


def ompl_cards() -> tuple[PlannerCard, ...]:
    """Return OMPL's planners with their parameters, sorted by name."""
    information = _minimal_space_information()
    return tuple(_card(information, name) for name in planner_names())


def make_planner(information: Any, name: str, parameters: Mapping[str, Scalar]) -> Any:
    """Return an OMPL planner with its parameters set.

    Raises:
        UnknownName: No planner, or no parameter of this one, has such a name.
        ProblemInvalid: A parameter's value has the wrong type or lies outside its range.
    """
    if name not in _planner_names():
        raise unknown_planner(name, planner_names())
    planner = getattr(og, name)(information)
    if name == "BFMT":
        # Its extension crashes the process (see `parameters`).
        planner.setExtendedFMT(False)
    try:
        set_parameters(planner, parameters)
    finally:
        # AORRTC crashes the process if it is destroyed without a setup (OMPL 2.0.1).
        planner.setup()
    if name == "RRTConnect" and not float(parameters.get("range", 0)):
        planner.setRange(min(RRT_CONNECT_RANGE, planner.getRange()))
    return planner


def _is_planner(item: Any) -> bool:
    return isinstance(item, type) and issubclass(item, ob.Planner) and item is not ob.Planner


def _minimal_space_information() -> Any:
    """Return a minimal space information for which planners can be made."""
    space = ob.RealVectorStateSpace(2)
    space.setBounds(0.0, 1.0)
    information = ob.SpaceInformation(space)
    information.setStateValidityChecker(_is_always_valid)
    information.setup()
    return information


def _is_always_valid(_: Any) -> bool:
    return True


def _card(information: Any, name: str) -> PlannerCard:
    planner = getattr(og, name)(information)
    try:
        return PlannerCard(name, tuple(_parameters(planner)))
    finally:
        planner.setup()


def _parameters(planner: Any) -> Iterator[PlannerParameter]:
    for name, setter in declared_parameters(planner).items():
        value = value_of(planner, setter)
        text = str(value).lower() if isinstance(value, bool) else f"{value:g}"
        low, high = range_of(name, value)
        range_text = describe_range(name, value)
        yield PlannerParameter(name, text, range_text, json_type(value), low, high)
