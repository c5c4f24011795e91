"""A new plan instead of a motion that does not hold any more, before it is carried out."""

from planning.errors import NotCertified
from service.errors import NotFinished, StartMismatch
from service.executions.models import Replanned
from service.executions.motions.asked_motion import AskedMotion, PlannedMotion
from service.executions.replanning.new_plan import KeptMotion, planned_anew
from service.plans.resource import motion_of, work_of
from service.plans.submit import PlanTerms
from service.scenes.store.scene_store import SceneStore


async def planned_instead(
    asked: AskedMotion, fault: NotCertified | StartMismatch, terms: PlanTerms, scenes: SceneStore
) -> tuple[AskedMotion, Replanned]:
    """Return a new plan from where the robot is to where a motion ends, and why there is one.

    Args:
        asked: The motion of a plan.
        fault: What it is refused for.
        terms: With what plans are made.
        scenes: Where its scene is.

    Raises:
        NotCertified: There is no plan: the fault, with the `replanned` job in its evidence.
        StartMismatch: The same.
    """
    if not isinstance(asked, PlannedMotion):  # requests of others say that they are refused
        raise fault
    goal = asked.motion.result.trajectory.positions[-1]
    group = asked.work.request.group
    asked_for = asked.demands
    kept = KeptMotion(asked.scene, group, goal, asked_for["planned"], asked_for["own"])
    try:
        plan = await planned_anew(kept.request(None), terms, scenes)
    except NotFinished as none:
        fault.evidence["replanned"] = none.evidence
        raise fault from none
    told = Replanned(plan=plan.id, code=fault.code, detail=str(fault))
    return PlannedMotion(work_of(plan), motion_of(plan)), told
