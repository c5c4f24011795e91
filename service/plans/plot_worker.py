"""Plots of delivered motions."""

import time
from typing import Any

from planning import Deadline
from planning.api.motion_series import motion_series
from service.jobs.context import TaskContext
from service.plans.charts import OF_DISTANCES, draw
from service.plans.models.goal_values import retime_value
from service.plans.models.request import Retime
from service.plans.models.trajectory_conversion import trajectory_value
from service.scenes.tasks import SceneWork
from service.scenes.world_cache import borrow_world

# A chart of a motion among few bodies takes a tenth of a second [s].
_ALLOWED = 20.0


def plot(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Return `svg`: a chart of the motion.

    Raises:
        InputError: The scene does not load any more.
        DeadlineExceeded: Its distances take too long.
    """
    trajectory = trajectory_value(payload["trajectory"])
    options = retime_value(Retime.model_validate(payload["retime"]))
    with borrow_world(SceneWork.model_validate(payload)) as world:
        series = motion_series(
            world,
            payload["group"],
            trajectory,
            options=options,
            margin=payload["margin"],
            distances=payload["name"] in OF_DISTANCES,
            deadline=Deadline.after(_ALLOWED, time.monotonic, channel.is_canceled),
        )
    return {"svg": draw(payload["name"], series)}
