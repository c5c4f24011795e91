"""Client: the HTTP API as methods."""

from collections.abc import Iterator
from types import TracebackType
from typing import Any, Self

import httpx

from service.client.errors import raise_for_problem
from service.client.events import Event, decode_events
from service.executions.models import Execution
from service.plans.models.plan import Plan
from service.scenes.models.scene import Scene
from service.scenes.models.summary import Model

_CONNECT_TIMEOUT = 5.0
_ANSWER_TIMEOUT = 120.0


class Client:
    """Speaks to one server. Use it as a context manager.

    Every method raises `ApiError` for a problem document and `httpx.TransportError` if the server
    cannot be reached.
    """

    def __init__(
        self,
        url: str,
        *,
        key: str | None = None,
        transport: httpx.BaseTransport | None = None,
    ) -> None:
        """Speak to a server.

        Args:
            url: Of the server, for example `http://127.0.0.1:8470`.
            key: API key, if the server asks for one.
            transport: What carries the requests, None for the network.
        """
        timeout = httpx.Timeout(_ANSWER_TIMEOUT, connect=_CONNECT_TIMEOUT)
        # Proxies of the environment are for the outside world, not for a server on this machine.
        # To read the certificates of the world takes 20 ms, and plain HTTP has no use for them.
        self._http = httpx.Client(
            base_url=url,
            headers={} if key is None else {"Authorization": f"Bearer {key}"},
            timeout=timeout,
            transport=transport,
            trust_env=False,
            verify=not url.startswith("http://"),
        )

    def __enter__(self) -> Self:
        """Begin to use it."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close all connections."""
        self._http.close()

    def is_ready(self) -> bool:
        """Return whether the server takes jobs."""
        return self._http.get("/readyz").is_success

    def models(self) -> list[str]:
        """Return the names of the robots there are."""
        names: list[str] = self._get("/v1/models").json()["items"]
        return names

    def model(self, name: str) -> Model:
        """Return what a robot can do."""
        return Model.model_validate_json(self._get(f"/v1/models/{name}").content)

    def add_scene(self, text: str | bytes, media_type: str = "application/yaml") -> Scene:
        """Post a scene."""
        headers = {"Content-Type": media_type}
        answer = self._send("POST", "/v1/scenes", content=text, headers=headers)
        return Scene.model_validate_json(answer.content)

    def scene(self, scene: str) -> Scene:
        """Return a scene."""
        return Scene.model_validate_json(self._get(f"/v1/scenes/{scene}").content)

    def delete_scene(self, scene: str) -> None:
        """Forget a scene."""
        self._send("DELETE", f"/v1/scenes/{scene}")

    def submit_plan(self, request: dict[str, Any], key: str | None = None) -> Plan:
        """Ask for a plan.

        Args:
            request: A `PlanRequest`.
            key: Idempotency key: the same key and request give the same job.
        """
        headers = {} if key is None else {"Idempotency-Key": key}
        answer = self._send("POST", "/v1/plans", json=request, headers=headers)
        return Plan.model_validate_json(answer.content)

    def plan(self, plan: str) -> Plan:
        """Return how far a plan is."""
        return Plan.model_validate_json(self._get(f"/v1/plans/{plan}").content)

    def cancel_plan(self, plan: str) -> Plan:
        """Ask for the end of a plan."""
        answer = self._send("POST", f"/v1/plans/{plan}/cancel")
        return Plan.model_validate_json(answer.content)

    def plan_events(self, plan: str, after: str | None = None) -> Iterator[Event]:
        """Yield what happens to a plan, from the first event or after one, until it is over."""
        return self._events(f"/v1/plans/{plan}/events", after)

    def trajectory_csv(self, plan: str) -> str:
        """Return the trajectory of a plan as CSV."""
        path = f"/v1/plans/{plan}/trajectory"
        return self._get(path, format="csv").text

    def replay(self, plan: str) -> str:
        """Return a page that replays a plan in 3-D."""
        return self._get(f"/v1/plans/{plan}/replay.html").text

    def edit_scene(self, scene: str, operations: list[dict[str, Any]]) -> Scene:
        """Carry out operations on a scene, all or none, and return its next revision."""
        answer = self._send("PATCH", f"/v1/scenes/{scene}", json={"operations": operations})
        return Scene.model_validate_json(answer.content)

    def scene_replay(self, scene: str) -> str:
        """Return a page that replays in 3-D what executions moved in a scene."""
        return self._get(f"/v1/scenes/{scene}/replay.html").text

    def execute(self, plan: str, speed: float = 1.0, title: str | None = None) -> Execution:
        """Carry out a plan in simulation, `speed` times as fast as real time.

        `title` is what replays of the scene call it.
        """
        body = {"plan": plan, "driver": "simulated", "speed": speed, "title": title}
        answer = self._send("POST", "/v1/executions", json=body)
        return Execution.model_validate_json(answer.content)

    def execution(self, execution: str) -> Execution:
        """Return how far an execution is."""
        answer = self._get(f"/v1/executions/{execution}")
        return Execution.model_validate_json(answer.content)

    def cancel_execution(self, execution: str) -> Execution:
        """Ask for the end of an execution."""
        answer = self._send("POST", f"/v1/executions/{execution}/cancel")
        return Execution.model_validate_json(answer.content)

    def execution_events(self, execution: str, after: str | None = None) -> Iterator[Event]:
        """Yield what happens to an execution, until it is over."""
        return self._events(f"/v1/executions/{execution}/events", after)

    def _get(self, path: str, **params: str) -> httpx.Response:
        return raise_for_problem(self._http.get(path, params=params))

    def _send(self, method: str, path: str, **content: Any) -> httpx.Response:
        return raise_for_problem(self._http.request(method, path, **content))

    def _events(self, path: str, after: str | None) -> Iterator[Event]:
        headers = {} if after is None else {"Last-Event-ID": after}
        with self._http.stream("GET", path, headers=headers) as answer:
            if answer.is_error:
                answer.read()
            yield from decode_events(raise_for_problem(answer))
