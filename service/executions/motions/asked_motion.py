"""Motions that are asked for: of a plan, or of the client; each knows how it is proven."""

from dataclasses import dataclass
from typing import Protocol, TypedDict

from planning.errors import UnknownName
from service.api.names import located
from service.executions.position import check_at_start
from service.executions.proofs.tasks import PROVE, PROVE_MOTION, ProofWork, ProvenMotion
from service.executions.requests import ExecutionRequest
from service.executions.tasks import MemberMotion
from service.jobs.service import JobService
from service.plans.models.request import PlanRequest
from service.plans.resource import DeliveredMotion
from service.plans.tasks import MotionWork
from service.scenes.models.summary import Group
from service.scenes.store.records import SceneRecord
from service.scenes.tasks import RequestWork, SceneWork
from service.scenes.validation import check_request, find_group
from service.trajectories.models import CertifyMotionRequest


class Demands(TypedDict):
    """What a motion keeps, by the request of its plan or by its own."""

    planned: PlanRequest | None
    own: CertifyMotionRequest | None
    members: list[MemberMotion]


class AskedMotion(Protocol):
    """A motion that is asked for."""

    @property
    def scene(self) -> str:
        """Id of the scene that it is in."""
        ...

    def group_in(self, record: SceneRecord) -> Group:
        """Return the group that moves.

        Raises:
            UnknownName: The scene has no such group, or none of something that the motion names.
        """
        ...

    @property
    def demands(self) -> Demands:
        """What it keeps."""
        ...

    async def proven(self, scene: SceneWork, group: Group, jobs: JobService) -> ProvenMotion:
        """Return the motion, once it is known to start where the group is and to hold.

        Raises:
            StartMismatch: It starts elsewhere.
            NotCertified: It cannot be proven.
        """
        ...


@dataclass(frozen=True)
class PlannedMotion:
    """The motion of a plan."""

    work: MotionWork
    motion: DeliveredMotion

    @property
    def scene(self) -> str:
        """Id of the scene that it was planned in."""
        return self.work.request.scene

    @property
    def demands(self) -> Demands:
        """What its plan was asked for; a motion backwards keeps what the one forwards did."""
        return {"planned": self.work.origin or self.work.request, "own": None, "members": []}

    def group_in(self, record: SceneRecord) -> Group:
        """Return the group that moves; raises as `AskedMotion`."""
        return find_group(record, self.work.request.group)

    async def proven(self, scene: SceneWork, group: Group, jobs: JobService) -> ProvenMotion:
        """Return the motion, by the plan's own proof or by a new one; raises as `AskedMotion`."""
        result, polynomial = self.motion.result, self.motion.polynomial
        check_at_start(group, result.start)
        clearance = result.certificate.min_clearance
        if not self.work.scene.is_same(scene.scene):
            work = ProofWork(
                library=scene.library,
                scene=scene.scene,
                request=self.work.request,
                origin=self.work.origin,
                trajectory=polynomial,
            )
            clearance = (await jobs.call(PROVE, work)).min_clearance
        return ProvenMotion(trajectory=polynomial, start=result.start, min_clearance=clearance)


@dataclass(frozen=True)
class OwnMotion:
    """A motion of the client.

    Attributes:
        request: The whole request, in which names are located.
        motion: The motion, and what it shall keep.
    """

    request: ExecutionRequest
    motion: CertifyMotionRequest

    @property
    def scene(self) -> str:
        """Id of the scene that it says."""
        return self.motion.scene

    @property
    def demands(self) -> Demands:
        """What it was asked to keep."""
        return {"planned": None, "own": self.motion, "members": []}

    def group_in(self, record: SceneRecord) -> Group:
        """Return the group that moves; raises as `AskedMotion`."""
        try:
            find_group(record, self.motion.group)
        except UnknownName as fault:
            raise located(fault, {"trajectory": {"group": self.motion.group}}) from None
        group = check_request(record, self.request)
        self.motion.check_group(group)
        return group

    async def proven(self, scene: SceneWork, group: Group, jobs: JobService) -> ProvenMotion:
        """Return the motion, by a proof in the scene; raises as `AskedMotion`."""
        found = await jobs.call(PROVE_MOTION, RequestWork.about(scene, self.motion))
        check_at_start(group, found.start)
        return found
