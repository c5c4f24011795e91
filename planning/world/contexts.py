"""A context of Drake's for questions at one instant."""

from weakref import WeakKeyDictionary

from pydrake.planning import RobotDiagram
from pydrake.systems.framework import Context

from planning.world.drake_model import DrakeModel

_made: WeakKeyDictionary[RobotDiagram, Context] = WeakKeyDictionary()


def shared_context(model: DrakeModel) -> Context:
    """Return a model's context that many share, making it the first time only.

    Making one takes longer than most questions. Whoever asks sets all positions first.
    """
    context = _made.get(model.diagram)
    if context is None:
        context = _made[model.diagram] = model.diagram.CreateDefaultContext()
    return context
