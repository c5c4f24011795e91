"""Planning, as a job."""

import time
from typing import Any

from planning import Deadline, plan
from planning.domain.plan import MotionPlan, Progress
from service.convert.goals import problem_value
from service.convert.plans import plan_wire
from service.convert.trajectories import polynomial_wire
from service.schemas.plan import PlanRequest
from service.tasks.channel import Channel
from service.tasks.cores import own_core
from service.tasks.roadmaps import shelf_in
from service.tasks.worlds import borrow_world

# Events are for people and progress bars: twenty a second are enough.
_EVENT_PERIOD = 0.05


class StageLog:
    """Tells the server which stage a plan is in; drops events that come too thick."""

    def __init__(self, channel: Channel) -> None:
        """Speak through `channel`."""
        self._channel = channel
        self._stage = ""
        self._last = 0.0

    def __call__(self, progress: Progress) -> None:
        """Emit `stage` when it changes, else `progress` now and then."""
        if progress.best_length is not None:
            self._tell_best(progress)
            return
        now = time.monotonic()
        is_new = progress.stage != self._stage
        if not is_new and now - self._last < _EVENT_PERIOD:
            return
        self._stage, self._last = progress.stage, now
        told = {"stage": progress.stage, "progress": progress.fraction, "detail": progress.detail}
        self._channel.emit("stage" if is_new else "progress", told)

    def _tell_best(self, progress: Progress) -> None:
        told = {"detail": progress.detail, "length": progress.best_length}
        self._channel.emit("best-so-far", told)


def plan_motion(payload: dict[str, Any], channel: Channel) -> dict[str, Any]:
    """Return the `result` of a plan, its exact `polynomial`, `timings` [s], `digest` and `graph`.

    The allowed time begins once the scene is loaded.

    Raises:
        WayproofError: There is no motion; the error says why.
    """
    request = PlanRequest.model_validate(payload["request"])
    log = StageLog(channel)
    log(Progress("load", 0.0))
    begun = time.monotonic()
    with borrow_world(payload) as world, own_core(payload.get("cores")) as pool:
        loaded = time.monotonic() - begun
        allowed = request.search.allowed_planning_time
        deadline = Deadline.after(allowed, time.monotonic, channel.is_canceled)
        found = plan(
            problem_value(request),
            world,
            deadline=deadline,
            on_progress=log,
            roadmaps=None if request.search.roadmap is None else shelf_in(payload["roadmaps"]),
            pool=pool,
        )
    return delivered(found, request, loaded)


def delivered(found: MotionPlan, request: PlanRequest, loaded: float) -> dict[str, Any]:
    """Return what a job keeps of a plan; loading the scene took `loaded` [s]."""
    return {
        "result": plan_wire(found, request.retime.sample_period, request.retime.num_points),
        "polynomial": polynomial_wire(found.trajectory),
        "timings": {"load": loaded, **found.timings},
        "digest": found.digest,
        "graph": None if found.graph is None else found.graph.plain,
    }
