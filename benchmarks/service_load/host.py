"""Host: servers to be measured, one at a time, on fresh data folders."""

import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import httpx

from benchmarks.service_load.measure import Measure
from benchmarks.serving.server import Server

ARM = {"name": "lone_arm", "robots": [{"name": "arm", "model": "ur5e", "positions": "home"}]}
# What happens at most in one question: a scene that takes longer is told as such.
_SLACK = 5.0


class Host:
    """Has one server run, in a folder that is removed afterwards.

    Attributes:
        http: Asks the server.
        url: Of the server.
    """

    def __init__(self, limit: float) -> None:
        """Start none yet.

        Args:
            limit: How long an answer may take [s].
        """
        self.http = httpx.Client()
        self.url = ""
        self._limit = limit
        self._folder = tempfile.TemporaryDirectory(prefix="wp-bench-", ignore_cleanup_errors=True)
        self._num_started = 0
        self._server: Server | None = None

    def __enter__(self) -> Self:
        """Begin."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the server and remove its folder."""
        self._end()
        self._folder.cleanup()

    def start(self, chosen: Mapping[str, str] | None = None) -> Server:
        """Start a new server on an empty data folder, in place of the one before; wait for it.

        Args:
            chosen: Variables of its settings.
        """
        self._num_started += 1
        return self._start_again(chosen)

    def kill_and_restart(self) -> None:
        """Kill the server and start another one on its data folder; wait for it."""
        self._start_again(None).be_ready()

    def _start_again(self, chosen: Mapping[str, str] | None) -> Server:
        self._end()
        folder = Path(self._folder.name)
        name = f"{self._num_started}"
        environment = {"WAYPROOF_QUERY_TIMEOUT": str(self._limit), **(chosen or {})}
        self._server = Server(folder / name, folder / f"{name}.log", environment)
        self._server.listen()
        self.url = self._server.url
        timeout = self._limit + _SLACK
        self.http = httpx.Client(base_url=self.url, timeout=timeout, trust_env=False)
        return self._server

    def need(self) -> Server:
        """Return a server that is ready, whichever."""
        if self._server is None:
            self.start().be_ready()
        return self._server or self.start()

    def drop(self) -> None:
        """End the server: it may be busy with what was given up."""
        self._end()

    @property
    def pid(self) -> int:
        """Number of the server's process; there is one since `need` or `start`."""
        return self.need().pid

    def post(self, path: str, body: Any = None) -> Any:
        """Return the JSON of an answer.

        Raises:
            httpx.HTTPStatusError: It is a refusal.
        """
        answer = self.http.post(path, json=body)
        answer.raise_for_status()
        return answer.json()

    def _end(self) -> None:
        server, self._server = self._server, None
        self.http.close()
        if server is not None:
            server.kill()


def arm_plan(scene: str) -> dict[str, Any]:
    """Return the request of a plan that takes milliseconds."""
    goal = {"type": "configuration", "name": "ready"}
    return {"scene": scene, "group": "arm", "goal": goal, "refine": {"method": "none"}}


def reason(fault: httpx.HTTPError) -> str:
    """Return why there is no answer, or none that helps, in a few words."""
    if isinstance(fault, httpx.HTTPStatusError):
        try:
            return f"{fault.response.status_code} {fault.response.json()['code']}"
        except (ValueError, KeyError):
            return str(fault.response.status_code)
    return type(fault).__name__


def timed(measure: Measure, host: Host, ask: Any) -> Any:
    """Do something and note how long it took, or why it failed; return what it gave.

    Args:
        measure: To be told.
        host: Is dropped if an answer takes too long.
        ask: Called; its faults of HTTP are noted.
    """
    began = time.perf_counter()
    try:
        given = ask()
    except httpx.TimeoutException:
        measure.faults.append(f"no answer in {time.perf_counter() - began:.0f} s")
        host.drop()
        return None
    except httpx.HTTPError as fault:
        measure.faults.append(f"{reason(fault)} after {time.perf_counter() - began:.1f} s")
        return None
    measure.seconds.append(time.perf_counter() - began)
    return given
