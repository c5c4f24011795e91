"""Drake contexts for queries at one instant."""

from typing import Any
from weakref import WeakKeyDictionary

from pydrake.planning import RobotDiagram
from pydrake.systems.framework import Context

from planning.world.collision.half_spaces import exclude_half_spaces, half_space_pairs_of
from planning.world.drake_model import DrakeModel

_cache: WeakKeyDictionary[RobotDiagram, Context] = WeakKeyDictionary()


def make_query_context(model: DrakeModel) -> Context:
    """Return a new context for all distance queries that Drake supports.

    Pairs with half spaces are not among them (`half_spaces`).
    """
    context: Any = model.diagram.CreateDefaultContext()
    if half_space_pairs_of(model).ids:
        graph_context = model.scene_graph.GetMyMutableContextFromRoot(context)
        exclude_half_spaces(model.scene_graph, graph_context)
    return context


def shared_context(model: DrakeModel) -> Context:
    """Return a model's shared context, cached by model.

    Making one takes longer than most queries. Every user sets all positions first.
    """
    context = _cache.get(model.diagram)
    if context is None:
        context = _cache[model.diagram] = make_query_context(model)
    return context
