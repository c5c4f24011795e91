"""New plans for executions whose motion does not hold: to where it ends, keeping what it keeps."""

import asyncio
from dataclasses import dataclass

from service.jobs.job import IdempotencyKey, Job
from service.jobs.service import JobService
from service.plans.models.goals import JointGoal
from service.plans.models.request import PlanRequest
from service.plans.plan_job import read_plan
from service.plans.resource import motion_of
from service.plans.submit import PlanTerms, plan_spec
from service.scenes.store.scene_store import SceneStore
from service.settings import Settings
from service.trajectories.models import CertifyMotionRequest

# A plan's own time limit ends it before [s].
_MOST_SECONDS = 600.0


@dataclass(frozen=True)
class Terms:
    """With what plans are asked for.

    Attributes:
        jobs: Where.
        settings: Of the server.
    """

    jobs: JobService
    settings: Settings


@dataclass(frozen=True)
class KeptMotion:
    """What is known of a motion by those who asked for it.

    Attributes:
        scene: Id of the scene.
        group: That moves.
        goal: Where it ends [rad or m].
        planned: Request of the plan that it is of, if of one.
        own: The request, if it is a motion of one's own.
    """

    scene: str
    group: str
    goal: list[float]
    planned: PlanRequest | None
    own: CertifyMotionRequest | None

    def request(self, start: list[float] | None) -> PlanRequest:
        """Return the request of a plan to the same configuration in the newest revision.

        Args:
            start: Where it begins [rad or m]; None for where the group is.
        """
        goal = JointGoal(type="joint", positions=self.goal)
        asked = self.planned
        if asked is None:
            asked = PlanRequest(
                scene=self.scene,
                group=self.group,
                goal=goal,
                path_constraints=[] if self.own is None else self.own.path_constraints,
                margin=None if self.own is None else self.own.margin,
            )
        return asked.model_copy(update={"revision": None, "start": start, "goal": goal})


async def planned_anew(request: PlanRequest, terms: PlanTerms, scenes: SceneStore) -> Job:
    """Return a plan once it is there.

    Args:
        request: What is planned.
        terms: With what plans are made.
        scenes: Where the scene is.

    Raises:
        NotFinished: It has found no motion; evidence has its `failure`.
        WayproofError: It cannot be asked for.
    """
    spec = await plan_spec(request, IdempotencyKey(None, {}), terms, scenes)
    job = await terms.jobs.submit(spec)
    try:
        await terms.jobs.wait(job, _MOST_SECONDS)
    except asyncio.CancelledError:
        await terms.jobs.cancel(job)
        raise
    found = await read_plan(terms.jobs, job.id)
    motion_of(found)  # raises if there is none
    return found
