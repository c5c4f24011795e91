"""Which robots there are."""

from typing import Any

from planning import describe_model, list_models
from service.jobs.channel import Channel
from service.scenes.summary_conversion import robot_wire
from service.scenes.world_cache import library_of


def name_models(payload: dict[str, Any], _: Channel) -> dict[str, Any]:
    """Return the names of all robots."""
    return {"items": list(list_models(library_of(payload["library"])))}


def show_model(payload: dict[str, Any], _: Channel) -> dict[str, Any]:
    """Return what a robot can do.

    Raises:
        UnknownName: There is none of that name.
        ModelInvalid: It does not load.
    """
    return robot_wire(describe_model(library_of(payload["library"]), payload["name"]))
