"""AsyncClient: all operations of a server, and what takes several of them, to await."""

import asyncio
import time
from collections.abc import AsyncIterator, Iterable
from typing import Any

from wayproof_client import models, requests
from wayproof_client.async_operations import AsyncOperations
from wayproof_client.connection import pauses
from wayproof_client.errors import ApiError, WaitTimeout
from wayproof_client.jobs import has_ended, name_of, require_success
from wayproof_client.plan_view import PLOTS, PlanView


class AsyncClient(AsyncOperations):
    """Speaks to one server without holding up the event loop; `Client` says what methods do."""

    async def is_ready(self) -> bool:
        """Return whether the server takes jobs, or raise as `Client.is_ready` does."""
        try:
            await self.get_readiness()
        except ApiError:
            return False
        return True

    async def run_plan(
        self, request: requests.PlanRequest, *, timeout: float | None = None
    ) -> models.Plan:
        """Ask for a plan and return it with its result, or raise as `Client.run_plan` does."""
        return await self.wait(await self.create_plan(request), timeout=timeout)

    async def run_execution(
        self, request: requests.ExecutionRequest, *, timeout: float | None = None
    ) -> models.Execution:
        """Carry out a plan and return how that ended, or raise as `Client.run_plan` does."""
        return await self.wait(await self.create_execution(request), timeout=timeout)

    async def wait[J: (models.Plan, models.Execution, models.RegionsJob, models.Batch)](
        self, job: J, *, timeout: float | None = None, check: bool = True
    ) -> J:
        """Return a job once it has ended, or raise as `Client.wait` does."""
        begun, left = time.monotonic(), pauses()
        while not has_ended(job):
            spent = time.monotonic() - begun
            if timeout is not None and spent >= timeout:
                raise WaitTimeout(job, timeout)
            pause = next(left)
            await self._pause(pause if timeout is None else min(pause, timeout - spent))
            job = await self.refresh(job)
        if check:
            require_success(job)
        return job

    async def refresh[J: (models.Plan, models.Execution, models.RegionsJob, models.Batch)](
        self, job: J
    ) -> J:
        """Return a job as it is now."""
        return await getattr(self, f"get_{name_of(job)}")(job.id)

    async def cancel[J: (models.Plan, models.Execution, models.RegionsJob, models.Batch)](
        self, job: J
    ) -> J:
        """Ask for the end of a job, and return it as it is then."""
        return await getattr(self, f"cancel_{name_of(job)}")(job.id)

    def follow(
        self,
        job: models.Plan | models.Execution | models.RegionsJob | models.Batch,
        *,
        last_event_id: str | None = None,
    ) -> AsyncIterator[Any]:
        """Yield what happens to a job, from its beginning or after an event, until it has ended."""
        stream = getattr(self, f"stream_{name_of(job)}_events")
        return stream(job.id, last_event_id=last_event_id)

    async def view(self, plan: models.Plan, plots: Iterable[str] = PLOTS) -> PlanView:
        """Return a plan to look at in a notebook: its replay and plots."""
        names: list[Any] = list(plots)
        replay, *drawings = await asyncio.gather(
            self.get_replay(plan.id), *(self.get_plot(plan.id, name) for name in names)
        )
        return PlanView.of(plan, replay, dict(zip(names, drawings, strict=True)))
