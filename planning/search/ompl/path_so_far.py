"""The path that an OMPL planner is improving, read while it is at work.

OMPL has a callback for it, which the binding cannot set (2.0.1: no caster for `std::function` of
states). So the tree of RRTstar and of what is made from it is followed from the goal back to the
start, and AORRTC's is read from the problem definition, where it puts each one.
"""

from typing import Any

import numpy as np
from ompl import base as ob
from ompl import geometric as og

from planning.domain.arrays import Array
from planning.search.ompl.spaces import SearchSpace


def path_so_far(planner: Any, space: SearchSpace) -> Array:
    """Return the path that a planner has now; it is read and not changed.

    Args:
        planner: That evaluates its termination condition, and has a solution.
        space: In which it searches.

    Returns:
        From the start to a goal, shape (n, nq); n = 0 for a planner that does not show it:
            BITstar's graph cannot be read without a leak.
    """
    if isinstance(planner, og.RRTstar):
        states = _states_in_tree(planner)
    elif isinstance(planner, og.AORRTC) and planner.getProblemDefinition().hasExactSolution():
        states = _states_of_solution(planner.getProblemDefinition())
    else:
        states = []
    rows = [space.read(state) for state in states]
    return np.array(rows).reshape(len(rows), space.manifold.num_positions)


def _states_in_tree(planner: Any) -> list[Any]:
    """Return the states from the start to the best goal; none without a goal in the tree."""
    tree = ob.PlannerData(planner.getSpaceInformation())
    planner.getPlannerData(tree)
    if not tree.numGoalVertices():
        return []
    chain = [tree.getGoalIndex(0)]
    while not tree.isStartVertex(chain[-1]):
        (parent,) = tree.getIncomingEdges(chain[-1])
        chain.append(parent)
    return [tree.getVertex(row).getState() for row in reversed(chain)]


def _states_of_solution(definition: Any) -> list[Any]:
    """Return the states of the best path that a planner has put into its problem definition."""
    found: list[Any] = definition.getSolutionPath().getStates()
    return found
