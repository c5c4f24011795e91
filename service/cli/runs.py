"""Runs: a plan or an execution from its request to its end, with its progress on stderr."""

from typing import TYPE_CHECKING, Any, cast

import typer

from service.cli.exit_codes import ExitCode
from service.cli.output import follow, show_failure
from wayproof_client import Client
from wayproof_client.models import Batch, Execution, Plan

if TYPE_CHECKING:
    from wayproof_client.requests import PlanRequest


def finished(client: Client, title: str, request: dict[str, Any]) -> Plan:
    """Ask for a plan, show its progress, and return it once it succeeded.

    Raises:
        typer.Exit: After a message, if it did not.
    """
    job = _ended(client, title, client.create_plan(cast("PlanRequest", request)))
    if job.result is None:
        show_failure(f"the plan {title}", job.failure)
        raise typer.Exit(ExitCode.NO_RESULT)
    return job


def executed(client: Client, name: str, plan: str, speed: float) -> Execution:
    """Carry out a plan, show its progress, and return how it ended.

    Raises:
        typer.Exit: After a message, if it did not succeed.
    """
    body: Any = {"plan": plan, "speed": speed, "title": name}
    execution = _ended(client, f"execute {name}", client.create_execution(body))
    if execution.state != "succeeded":
        show_failure(f"the execution of {name}", execution.failure)
        raise typer.Exit(ExitCode.NO_RESULT)
    return execution


def planned_all(client: Client, requests: list[dict[str, Any]]) -> Batch:
    """Ask for plans, show how far they are, and return their batch once all have ended."""
    problems = cast("list[PlanRequest]", requests)
    batch = client.create_batch({"problems": problems})
    return _ended(client, f"{len(requests)} plans", batch)


def _ended[J: (Plan, Execution, Batch)](client: Client, title: str, job: J) -> J:
    """Return a job once it has ended; what is interrupted does not go on at the server."""
    total = len(job.plans) if isinstance(job, Batch) else 1
    try:
        follow(title, client.follow(job), total)
    except KeyboardInterrupt:
        client.cancel(job)
        raise
    return client.wait(job, check=False)
