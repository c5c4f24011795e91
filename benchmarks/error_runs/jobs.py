"""Failures of jobs: queues that are full, workers that end or stand still, servers that do."""

import os
import resource
import signal
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.error_runs.asking import Asking
from benchmarks.error_runs.made import Made
from benchmarks.error_runs.serving import (
    ARM,
    arm_plan,
    asked,
    ended,
    endless_plan,
    held,
    walled_plan,
    workers,
)
from benchmarks.serving.server import Server, pause

_PLANS = "POST /v1/plans"
_FEW = {"WAYPROOF_PLAN_SLOTS": "1", "WAYPROOF_MAX_QUEUED": "1"}
_IMPATIENT = {
    "WAYPROOF_QUERY_SLOTS": "1",
    "WAYPROOF_QUEUE_TIMEOUT": "1",
    "WAYPROOF_QUERY_TIMEOUT": "6",
}
# The least that the setting takes [bytes].
_LITTLE_MEMORY = str(2**29)
_SLOWLY = 0.02
# After which a plan runs again whose worker has ended [s].
_NEXT_ATTEMPT = 1.0
# More questions at once than there are workers for them.
_CROWD = 4


def jobs() -> Iterator[Made]:
    """Yield what ends so."""
    with asked(_FEW) as (asking, _):
        yield from _full(asking)
        yield from _in_use(asking)
    with asked(_IMPATIENT) as (asking, server):
        yield _queue_timeout(asking, server)
    with asked({}) as (asking, server):
        yield _crashed(asking, server)
    with asked({}) as (asking, server):
        execution = _moving(asking)
        with held(server):
            failure = ended(asking, f"/v1/executions/{execution['id']}")["failure"]
        yield Made("worker_unresponsive", "POST /v1/executions", execution["body"], failure)
    yield _restarted()
    with asked({"WAYPROOF_WORKER_MEMORY": _LITTLE_MEMORY}) as (asking, _):
        yield _out_of_memory(asking)
    with asked({}) as (asking, server):
        yield _unwritable(asking, server)


def _full(asking: Asking) -> Iterator[Made]:
    """Fill the queue, then cancel what runs."""
    scene = asking.scene(ARM)
    plan = endless_plan(asking)
    asking.done("POST", "/v1/plans", arm_plan(scene))
    body = arm_plan(scene)
    yield Made("queue_full", _PLANS, body, asking.json("POST", "/v1/plans", body))
    path = f"/v1/plans/{plan}"
    asking.done("POST", f"{path}/cancel")
    yield Made("canceled", f"POST {path}/cancel", None, ended(asking, path)["failure"])


def _queue_timeout(asking: Asking, server: Server) -> Made:
    """Ask while the only worker that answers questions stands still."""
    scene = asking.scene(ARM)
    path = f"/v1/scenes/{scene}/check"
    body = {"group": "arm", "configurations": [[0, -1.57, 1.57, -1.57, -1.57, 0]]}
    with held(server), ThreadPoolExecutor(_CROWD) as crowd:
        answers = [crowd.submit(asking.json, "POST", path, body) for _ in range(_CROWD)]
        problem = next(as_completed(answers)).result()
    return Made("queue_timeout", f"POST {path}", body, problem)


def _crashed(asking: Asking, server: Server) -> Made:
    """End workers as a fault of native code would, as often as the plan is tried."""
    path = f"/v1/plans/{endless_plan(asking)}"
    request = asking.done("GET", path)["request"]
    while (job := asking.done("GET", path))["finished_at"] is None:
        for pid in workers(server):
            os.kill(pid, signal.SIGSEGV)
        pause(_NEXT_ATTEMPT)
    return Made("worker_crashed", _PLANS, request, job["failure"])


def _in_use(asking: Asking) -> Iterator[Made]:
    """Delete a plan that an execution carries out."""
    execution = _moving(asking)
    path = f"/v1/plans/{execution['body']['plan']}"
    yield Made("resource_in_use", f"DELETE {path}", None, asking.json("DELETE", path))
    asking.done("POST", f"/v1/executions/{execution['id']}/cancel")


def _moving(asking: Asking) -> dict[str, Any]:
    """Return the id and the request of an execution that has begun to move."""
    plan = asking.planned(arm_plan(asking.scene(ARM)))
    body = {"plan": plan["id"], "speed": _SLOWLY}
    execution = asking.done("POST", "/v1/executions", body)["id"]
    asking.moving(execution)
    return {"id": execution, "body": body}


def _restarted() -> Made:
    """Kill a server while a robot moves, and start another one on its records."""
    with TemporaryDirectory(prefix="wayproof-errors-", ignore_cleanup_errors=True) as folder:
        with asked({}, Path(folder)) as (asking, server):
            execution = _moving(asking)
            server.kill()
        with asked({}, Path(folder)) as (asking, _):
            failure = ended(asking, f"/v1/executions/{execution['id']}")["failure"]
    return Made("server_restarted", "POST /v1/executions", execution["body"], failure)


def _out_of_memory(asking: Asking) -> Made:
    """Have a planner keep configurations for as long as there is memory."""
    search = {"planner": "PRM", "allowed_planning_time": 600.0, "attempts": 1, "solve_time": 500.0}
    body = walled_plan(asking, search)
    plan = asking.done("POST", "/v1/plans", body)
    failure = ended(asking, f"/v1/plans/{plan['id']}")["failure"]
    return Made("memory_limit_exceeded", _PLANS, body, failure)


def _unwritable(asking: Asking, server: Server) -> Made:
    """Ask a server whose files may not grow, as on a full disk."""
    body = arm_plan(asking.scene(ARM))
    before = resource.prlimit(server.pid, resource.RLIMIT_FSIZE)
    try:
        resource.prlimit(server.pid, resource.RLIMIT_FSIZE, (1, before[1]))
        problem = asking.json("POST", "/v1/plans", body)
    finally:
        resource.prlimit(server.pid, resource.RLIMIT_FSIZE, before)
    return Made("database_unavailable", _PLANS, body, problem)
