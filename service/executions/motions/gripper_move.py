"""GripperMove: the fingers of a gripper open or close, from where they are."""

from dataclasses import dataclass

from planning.errors import UnknownName
from service.api.names import located
from service.executions.gripping.requests import GripperRequest
from service.executions.motions.asked_motion import Demands
from service.executions.position import check_at_start
from service.executions.proofs.tasks import PROVE_GRIPPER, GripperWork, ProvenMotion
from service.executions.requests import ExecutionRequest
from service.jobs.service import JobService
from service.scenes.models.summary import Group
from service.scenes.store.records import SceneRecord
from service.scenes.tasks import SceneWork
from service.scenes.validation import check_request, find_group


@dataclass(frozen=True)
class GripperMove:
    """The motion of a gripper.

    Attributes:
        request: The whole request, in which names are located.
        gripper: What it shall do.
    """

    request: ExecutionRequest
    gripper: GripperRequest

    @property
    def scene(self) -> str:
        """Id of the scene that it is in."""
        return self.gripper.scene

    @property
    def demands(self) -> Demands:
        """Nothing but what every motion keeps."""
        return {"planned": None, "own": None, "members": []}

    def group_in(self, record: SceneRecord) -> Group:
        """Return the group that moves; raises as `AskedMotion`."""
        try:
            find_group(record, self.gripper.group)
        except UnknownName as fault:
            raise located(fault, {"gripper": {"group": self.gripper.group}}) from None
        return check_request(record, self.request)

    async def proven(self, scene: SceneWork, group: Group, jobs: JobService) -> ProvenMotion:
        """Return the motion from where the fingers are; raises as `AskedMotion`.

        Raises:
            GraspMissed: The fingers do not reach the object that they shall hold.
        """
        work = GripperWork(
            library=scene.library,
            scene=scene.scene,
            request=self.gripper,
            group=group.name,
            tool_frame=tool_frame_of(group),
        )
        found = await jobs.call(PROVE_GRIPPER, work)
        check_at_start(group, found.start)
        return found


def tool_frame_of(group: Group) -> str:
    """Return the frame that a gripper holds objects in if none is named."""
    return group.tool_frames[0] if group.tool_frames else ""
