"""PlansTogether: motions of several plans that are carried out as one motion with one clock."""

from collections.abc import Sequence
from dataclasses import dataclass

from planning.domain.robot.spanning_group import common_joint
from planning.errors import ProblemInvalid
from service.executions.motions.asked_motion import Demands, PlannedMotion
from service.executions.position import check_at_start
from service.executions.proofs.tasks import PROVE_TOGETHER, ProvenMotion, TogetherWork
from service.executions.tasks import MemberMotion
from service.jobs.service import JobService
from service.scenes.models.summary import Group
from service.scenes.store.records import SceneRecord
from service.scenes.tasks import SceneWork
from service.scenes.validation import joined_group


@dataclass(frozen=True)
class PlansTogether:
    """Motions of several plans of one scene, as one motion of the group that spans theirs.

    Attributes:
        motions: Those of the plans, the most urgent first.
        delays: When each begins [s]; None for the smallest delays that are proven.
    """

    motions: Sequence[PlannedMotion]
    delays: list[float] | None

    @property
    def scene(self) -> str:
        """Id of the scene that the first one was planned in."""
        return self.motions[0].scene

    @property
    def demands(self) -> Demands:
        """What each plan was asked for."""
        return {"planned": None, "own": None, "members": self._members}

    @property
    def _members(self) -> list[MemberMotion]:
        return [
            MemberMotion(
                planned=motion.work.origin or motion.work.request,
                trajectory=motion.motion.polynomial,
            )
            for motion in self.motions
        ]

    def group_in(self, record: SceneRecord) -> Group:
        """Return the group that spans those of the plans.

        Raises:
            ProblemInvalid: A plan is of another scene, or moves a joint that one before it moves.
            UnknownName: The scene has no such group any more.
        """
        groups: list[Group] = []
        for i, motion in enumerate(self.motions):
            if motion.scene != record.id:
                message = f"plans.{i}: it is a plan of scene {motion.scene}, not of {record.id}"
                raise _at_plan(i, ProblemInvalid(message, {"scene": motion.scene}))
            group = motion.group_in(record)
            _check_apart(i, group, groups)
            groups.append(group)
        return joined_group(record, [group.name for group in groups], "plans")

    async def proven(self, scene: SceneWork, group: Group, jobs: JobService) -> ProvenMotion:
        """Return the motion, once it is known to start where the group is and to hold.

        Raises:
            StartMismatch: It starts elsewhere.
            ScheduleNotFound: No delays keep the motions apart.
            NotCertified: It cannot be proven.
        """
        start = [value for each in self.motions for value in each.motion.result.start]
        check_at_start(group, start)
        work = TogetherWork(
            library=scene.library, scene=scene.scene, members=self._members, delays=self.delays
        )
        return await jobs.call(PROVE_TOGETHER, work)


def _check_apart(i: int, group: Group, before: Sequence[Group]) -> None:
    """Raise if a plan moves a joint that one of those before it moves."""
    own = {joint.name for joint in group.joints}
    for other in before:
        shared = [joint.name for joint in other.joints if joint.name in own]
        if shared:
            raise _at_plan(i, common_joint(shared[0], [other.name, group.name]))


def _at_plan(i: int, fault: ProblemInvalid) -> ProblemInvalid:
    """Return a fault of one of the plans, with the place of its id in the request."""
    error = {"pointer": f"/plans/{i}", "message": fault.detail, "nearest": []}
    place = {"field": f"plans.{i}", "errors": [error]}
    return ProblemInvalid(fault.detail, {**fault.evidence, **place})
