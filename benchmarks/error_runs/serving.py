"""asked(): a server with settings of its own, for as long as something goes wrong on it."""

import os
import signal
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.error_runs.asking import Asking
from benchmarks.serving.server import Server

ARM: dict[str, Any] = {
    "name": "lone_arm",
    "robots": [{"name": "arm", "model": "ur5e", "positions": "home"}],
}
_TO_READY: dict[str, Any] = {"group": "arm", "goal": {"type": "configuration", "name": "ready"}}
# No way leads through the wall, which no planner knows.
_WALLED: dict[str, Any] = {
    "name": "walled",
    "robots": [{"name": "body", "model": "planar_l", "positions": [-0.35, -0.3, 0]}],
    "objects": [{"name": "wall", "shape": {"box": [0.02, 9, 0.2]}}],
}


@contextmanager
def asked(
    settings: dict[str, str], folder: Path | None = None, *, ready: bool = True
) -> Generator[tuple[Asking, Server]]:
    """Lend a server, and what asks it.

    Args:
        settings: Variables `WAYPROOF_*`.
        folder: Its data folder; None for one that is removed afterwards.
        ready: Whether to wait until it takes jobs.
    """
    with TemporaryDirectory(prefix="wayproof-errors-", ignore_cleanup_errors=True) as temporary:
        log = Path(temporary) / "log"
        environment = {"WAYPROOF_NICENESS": "0", **settings}
        with Server(folder or Path(temporary) / "state", log, environment) as server:
            if ready:
                server.be_ready()
            yield Asking(server.url), server


def arm_plan(scene: str) -> dict[str, Any]:
    """Return the request of a plan of `ARM` that takes milliseconds."""
    return {"scene": scene, **_TO_READY}


def endless_plan(asking: Asking) -> str:
    """Begin a plan that takes minutes, and return its id once it searches."""
    search = {"allowed_planning_time": 600.0, "attempts": 100, "solve_time": 2.0}
    plan = str(asking.done("POST", "/v1/plans", walled_plan(asking, search))["id"])
    while asking.done("GET", f"/v1/plans/{plan}")["stage"] != "search":
        pass
    return plan


def walled_plan(asking: Asking, search: dict[str, Any]) -> dict[str, Any]:
    """Return the request of a plan to where no way leads."""
    goal = {"type": "joint", "positions": [0.3, -0.3, 0.0]}
    return {"scene": asking.scene(_WALLED), "group": "body", "goal": goal, "search": search}


def ended(asking: Asking, path: str) -> Any:
    """Return a job once it has ended."""
    while (job := asking.done("GET", path))["finished_at"] is None:
        pass
    return job


def workers(server: Server) -> Iterator[int]:
    """Yield the processes that run tasks: grandchildren of the server's."""
    parents = _parents()
    for pid, parent in parents.items():
        if parents.get(parent) == server.pid:
            yield pid


@contextmanager
def held(server: Server) -> Generator[None]:
    """Have the server's workers stand still meanwhile."""
    stopped = list(workers(server))
    try:
        for pid in stopped:
            os.kill(pid, signal.SIGSTOP)
        yield
    finally:
        for pid in set(stopped) & set(_parents()):
            os.kill(pid, signal.SIGCONT)


def _parents() -> dict[int, int]:
    """Return the parent of every process that is there."""
    found: dict[int, int] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal():
            try:
                fields = (entry / "stat").read_text().rsplit(")", 1)[1].split()
            except OSError:
                continue
            found[int(entry.name)] = int(fields[1])
    return found
