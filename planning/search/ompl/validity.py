"""What OMPL calls back: the validity of a state and of a motion."""

from collections.abc import Callable
from typing import Any, override

from ompl import base as ob

from planning.search.collision_oracle import WatchedOracle
from planning.search.edges import EdgeChecker
from planning.search.ompl.projected_space import ProjectedSpace
from planning.search.ompl.spaces import SearchSpace


class EdgeMotionValidator(ob.MotionValidator):
    """Checks a motion as an edge; what the oracle raises passes through the planner to us."""

    def __init__(self, ompl: Any, space: SearchSpace, edges: EdgeChecker) -> None:
        """Validate motions of an OMPL space information."""
        super().__init__(ompl)
        self._read = space.read
        self._is_free = edges.is_free

    @override
    def checkMotion(self, arg0: Any, arg1: Any, /) -> bool:
        """Return whether the geodesic is free, its first state taken for granted."""
        return self._is_free(self._read(arg0), self._read(arg1))


class WholeEdgeValidator(ob.MotionValidator):
    """Checks a motion with both of its ends, so that nobody need ask about states."""

    def __init__(self, ompl: Any, space: SearchSpace, edges: EdgeChecker) -> None:
        """Validate motions of an OMPL space information."""
        super().__init__(ompl)
        self._numbers = space.numbers
        self._is_free = edges.is_whole_edge_free

    @override
    def checkMotion(self, arg0: Any, arg1: Any, /) -> bool:
        """Return whether the geodesic is free, its first state included."""
        return self._is_free(self._numbers(arg0), self._numbers(arg1))


def state_validity(space: SearchSpace, oracle: WatchedOracle) -> Callable[[Any], bool]:
    """Return OMPL's question about one state.

    It is a function and not a subclass of `ob.StateValidityChecker`: that one and its space
    information keep each other alive, and a worker that plans for days would grow.
    """
    read, is_free = space.read, oracle.is_free

    def is_valid(state: Any) -> bool:
        return is_free(read(state))

    return is_valid


def space_information(
    space: SearchSpace, oracle: WatchedOracle, edges: EdgeChecker, planner: str
) -> Any:
    """Return OMPL's space information, ready to plan with.

    RRTConnect adds no state but by a motion: checked with both ends, that is one question for two.
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
