"""TaskCalls: short tasks that workers carry out at once, for coroutines of one event loop."""

from collections.abc import Awaitable, Callable, Coroutine
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from service.jobs.dispatch.calls import Call, CallResult
from service.jobs.dispatch.dispatcher import Dispatcher
from service.jobs.json_text import Encoded
from service.jobs.task import Task


@dataclass(frozen=True)
class CallTerms:
    """On what terms short tasks are called.

    Attributes:
        time_limit: For the work [s].
        worker_timeout: How long a call may wait for a worker [s].
        answer: Awaits a call for the client of the request; None to await it as it is.
    """

    time_limit: float = 60.0
    worker_timeout: float = 30.0
    answer: Callable[[Coroutine[Any, Any, CallResult]], Awaitable[CallResult]] | None = None


class TaskCalls:
    """Calls short tasks by way of a dispatcher."""

    def __init__(self, dispatcher: Dispatcher, terms: CallTerms) -> None:
        """Call by way of a dispatcher that runs already, on some terms."""
        self._dispatcher = dispatcher
        self._terms = terms

    async def call[In: BaseModel, Out: BaseModel](
        self, task: Task[In, Out], work: In, size: int = 0
    ) -> Out:
        """Have a worker carry out a short task and return its answer; it ends if the client leaves.

        Args:
            task: Of a queue of calls.
            work: What it is given.
            size: Number of items: twice as many take longer.

        Raises:
            WayproofError: What the task raised, or that it took too long, or that it crashed, or
                that no worker was free in time.
        """
        return task.result.model_validate(await self._call(task, work, size=size))

    async def call_text[In: BaseModel, Out: BaseModel](
        self, task: Task[In, Out], work: In, size: int = 0
    ) -> Encoded:
        """Call as `call` does, for an answer that is passed on as it is."""
        text: Encoded = await self._call(task, work, size=size, is_raw=True)
        return text

    async def call_loading[In: BaseModel, Out: BaseModel](
        self, task: Task[In, Out], work: In, size: int = 0
    ) -> Out:
        """Call as `call` does, for a task that loads the world whose `digest` it returns."""
        more = {"digest_field": "digest", "is_partly_raw": True}
        return task.result.model_validate(await self._call(task, work, size=size, **more))

    async def _call(self, task: Task[Any, Any], work: BaseModel, **more: Any) -> Any:
        payload, terms = work.model_dump(mode="json"), self._terms
        digest = payload["scene"]["digest"] if "scene" in payload else None
        limits = (terms.time_limit, terms.worker_timeout)
        call = self._dispatcher.call(Call(task.name, payload, task.queue, *limits, digest, **more))
        return (await (call if terms.answer is None else terms.answer(call))).content
