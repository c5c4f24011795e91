"""What every worker does first, so that its first job is as quick as the next."""

from typing import Any

from planning import ModelLibrary, list_models, list_planners
from service.tasks.channel import Channel


def warm_up(_: dict[str, Any], __: Channel) -> dict[str, Any]:
    """Open the doors that import Drake and OMPL."""
    return {
        "models": len(list_models(ModelLibrary.bundled())),
        "planners": len(list_planners()),
    }
