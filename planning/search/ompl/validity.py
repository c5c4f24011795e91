"""Validity callbacks of OMPL: state validity checker and motion validators."""

from collections.abc import Callable
from typing import Any, override

from ompl import base as ob

from planning.search.collision_oracle import WatchedOracle
from planning.search.edges import EdgeChecker
from planning.search.ompl.projected_space import ProjectedSpace
from planning.search.ompl.spaces import SearchSpace


class EdgeMotionValidator(ob.MotionValidator):
    """Motion validator by edges; the oracle's exceptions pass through the planner to the caller."""

    def __init__(self, ompl: Any, space: SearchSpace, edges: EdgeChecker) -> None:
        """Validate motions of an OMPL space information."""
        super().__init__(ompl)
        self._read = space.read
        self._is_free = edges.is_free

    @override
    def checkMotion(self, arg0: Any, arg1: Any, /) -> bool:
        """Return whether the geodesic is free; its first state is assumed to be."""
        return self._is_free(self._read(arg0), self._read(arg1))


class WholeEdgeValidator(ob.MotionValidator):
    """Motion validator that includes both ends, so that no state needs a check of its own."""

    def __init__(self, ompl: Any, space: SearchSpace, edges: EdgeChecker) -> None:
        """Validate motions of an OMPL space information."""
        super().__init__(ompl)
        self._read_list = space.read_list
        self._is_free = edges.is_whole_edge_free

    @override
    def checkMotion(self, arg0: Any, arg1: Any, /) -> bool:
        """Return whether the geodesic is free, its first state included."""
        return self._is_free(self._read_list(arg0), self._read_list(arg1))


def state_validity(space: SearchSpace, oracle: WatchedOracle) -> Callable[[Any], bool]:
    """Return OMPL's state validity callback.

    It is a function and not a subclass of `ob.StateValidityChecker`: that one and its space
    information keep each other alive, and the memory of a long-lived worker would grow.
    """
    read, is_free = space.read, oracle.is_free

    def is_valid(state: Any) -> bool:
        return is_free(read(state))

    return is_valid


def space_information(
    space: SearchSpace, oracle: WatchedOracle, edges: EdgeChecker, planner: str
) -> Any:
    """Return OMPL's space information after its setup.

    RRTConnect adds states by motions only: checked with both ends, one call replaces two.
    """
    if isinstance(space, ProjectedSpace):
        return space.information(oracle)
    ompl = ob.SpaceInformation(space.ompl)
    if planner == "RRTConnect":
        ompl.setStateValidityChecker(ob.AllValidStateValidityChecker(ompl))
        ompl.setMotionValidator(WholeEdgeValidator(ompl, space, edges))
    else:
        ompl.setStateValidityChecker(state_validity(space, oracle))
        ompl.setMotionValidator(EdgeMotionValidator(ompl, space, edges))
    ompl.setup()
    return ompl
