"""Client: all operations of a server, and what takes several of them."""

import time
from collections.abc import Iterable, Iterator
from typing import Any, override

from wayproof_client import models, requests
from wayproof_client.call import Call
from wayproof_client.connection import pauses
from wayproof_client.errors import ApiError, WaitTimeout
from wayproof_client.jobs import has_ended, name_of, require_success
from wayproof_client.operations import Operations
from wayproof_client.plan_view import PLOTS, PlanView
from wayproof_client.shown_plan import ShownPlan


class Client(Operations):
    """Speaks to one server, call by call; `AsyncClient` has the same to await."""

    @override
    def ask(self, call: Call, kind: Any) -> Any:
        """Return the answer as a model; a plan can show itself in a notebook."""
        answer = super().ask(call, kind)
        if isinstance(answer, ShownPlan):
            answer.show_by(self.view)
        return answer

    def is_ready(self) -> bool:
        """Return whether the server takes jobs.

        Raises:
            httpx.TransportError: It is not reached.
        """
        try:
            self.get_readiness()
        except ApiError:
            return False
        return True

    def run_plan(
        self, request: requests.PlanRequest, *, timeout: float | None = None
    ) -> models.Plan:
        """Ask for a plan and return it with its result.

        Raises:
            JobFailed: There is none: its `failure` says why.
            WaitTimeout: It takes longer than `timeout` [s].
        """
        return self.wait(self.create_plan(request), timeout=timeout)

    def run_execution(
        self, request: requests.ExecutionRequest, *, timeout: float | None = None
    ) -> models.Execution:
        """Carry out a plan, and return how that ended; raises as `run_plan` does."""
        return self.wait(self.create_execution(request), timeout=timeout)

    def wait[J: (models.Plan, models.Execution, models.RegionsJob, models.Batch)](
        self, job: J, *, timeout: float | None = None, check: bool = True
    ) -> J:
        """Return a job once it has ended.

        Args:
            job: A plan, an execution, regions or a batch.
            timeout: How long to wait at most [s]; None for as long as it takes.
            check: Whether to raise if it has no result.

        Raises:
            JobFailed: It has none.
            WaitTimeout: It takes longer.
        """
        begun, left = time.monotonic(), pauses()
        while not has_ended(job):
            spent = time.monotonic() - begun
            if timeout is not None and spent >= timeout:
                raise WaitTimeout(job, timeout)
            pause = next(left)
            self._pause(pause if timeout is None else min(pause, timeout - spent))
            job = self.refresh(job)
        if check:
            require_success(job)
        return job

    def refresh[J: (models.Plan, models.Execution, models.RegionsJob, models.Batch)](
        self, job: J
    ) -> J:
        """Return a job as it is now."""
        return getattr(self, f"get_{name_of(job)}")(job.id)

    def cancel[J: (models.Plan, models.Execution, models.RegionsJob, models.Batch)](
        self, job: J
    ) -> J:
        """Ask for the end of a job, and return it as it is then."""
        return getattr(self, f"cancel_{name_of(job)}")(job.id)

    def follow(
        self,
        job: models.Plan | models.Execution | models.RegionsJob | models.Batch,
        *,
        last_event_id: str | None = None,
    ) -> Iterator[Any]:
        """Yield what happens to a job, from its beginning or after an event, until it has ended."""
        stream = getattr(self, f"stream_{name_of(job)}_events")
        return stream(job.id, last_event_id=last_event_id)

    def view(self, plan: models.Plan, plots: Iterable[str] = PLOTS) -> PlanView:
        """Return a plan to look at in a notebook: its replay and plots."""
        names: Any = plots
        drawings = {name: self.get_plot(plan.id, name) for name in names}
        return PlanView.of(plan, self.get_replay(plan.id), drawings)
