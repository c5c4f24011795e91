"""/v1/plans/{id}/bundle.zip: a finished plan with all that it was made from."""

from anyio import to_thread
from fastapi import APIRouter, Response

from service.api.dependencies import JobsDep
from service.api.params import PlanId
from service.api.responses import problems
from service.api.routing.strict_route import StrictRoute
from service.errors import NotFinished, SceneNotKept
from service.jobs.states import JobState
from service.plans.bundle.writer import bundled_outcome, write_bundle
from service.plans.tasks import PLAN, REVERSE

router = APIRouter(route_class=StrictRoute, prefix="/v1/plans/{plan}/bundle.zip", tags=["plans"])

_BINARY = {"type": "string", "format": "binary", "description": "A ZIP file"}
_BUNDLED = {JobState.SUCCEEDED, JobState.FAILED}
_TASKS = {PLAN.name, REVERSE.name}


class _Zip(Response):
    media_type = "application/zip"


@router.get(
    "",
    operation_id="getPlanBundle",
    response_class=_Zip,
    responses={
        200: {"content": {"application/zip": {"schema": _BINARY}}},
        **problems(404, 409, 422),
    },
)
async def get_bundle(plan: PlanId, jobs: JobsDep) -> Response:
    """Pack a plan that succeeded or failed: request, scene, models' files, result, versions, test.

    `wayproof replay bundle.zip` plans it again elsewhere, and says whether the same bytes come out.
    """
    job = await jobs.job("plan", plan, bundled_outcome)
    if job.state not in _BUNDLED or job.task not in _TASKS:
        evidence = {"id": job.id, "state": job.state, "failure": job.failure}
        raise NotFinished(f"plan {job.id} is {job.state}: there is nothing to replay", evidence)
    artifacts = await jobs.artifacts_of(job)
    if job.payload["scene"]["document"] not in artifacts:
        raise SceneNotKept.of(job.payload["scene"]["digest"])
    content = await to_thread.run_sync(write_bundle, job, artifacts)
    headers = {"Content-Disposition": f'attachment; filename="{job.id}.zip"'}
    return _Zip(content, headers=headers)
