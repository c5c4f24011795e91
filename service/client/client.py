"""Client: that of `wayproof_client`, with the names of methods that it had in this package."""

from collections.abc import Iterator
from typing import Any, cast, override

import wayproof_client
from wayproof_client import requests
from wayproof_client.call import Call
from wayproof_client.events import Event
from wayproof_client.models import EditedScene, Execution, Model, Plan, Scene


class Client(wayproof_client.Client):
    """Speaks to one server; methods that are not of its base stand for one of them each."""

    def models(self) -> list[str]:
        """Return the names of the robots there are."""
        return self.list_models().items

    def model(self, name: str) -> Model:
        """Return what a robot can do."""
        return self.get_model(name)

    def add_scene(self, text: str | bytes, media_type: str = "application/yaml") -> Scene:
        """Post a scene."""
        return self.create_scene(text, media_type=cast("Any", media_type))

    def scene(self, scene: str) -> Scene:
        """Return a scene."""
        return self.get_scene(scene)

    def submit_plan(self, request: dict[str, Any], key: str | None = None) -> Plan:
        """Ask for a plan; the same key and request give the same one."""
        return self.create_plan(cast("requests.PlanRequest", request), idempotency_key=key)

    def plan(self, plan: str) -> Plan:
        """Return how far a plan is."""
        return self.get_plan(plan)

    def plan_events(self, plan: str, after: str | None = None) -> Iterator[Event]:
        """Yield what happens to a plan, from the first event or after one, until it is over."""
        return self._raw_events("/v1/plans/{job}/events", plan, after)

    def trajectory_csv(self, plan: str) -> str:
        """Return the trajectory of a plan as CSV."""
        return self.get_trajectory_as(plan, format="csv").decode()

    def replay(self, plan: str) -> str:
        """Return a page that replays a plan in 3-D."""
        return self.get_replay(plan)

    @override
    def edit_scene(
        self,
        scene: str,
        body: requests.SceneEdit | list[dict[str, Any]],
        *,
        if_match: str | None = None,
    ) -> EditedScene:
        """Carry out operations on a scene, all or none, and return its next revision."""
        edit: Any = {"operations": body} if isinstance(body, list) else body
        return super().edit_scene(scene, edit, if_match=if_match)

    def scene_replay(self, scene: str) -> str:
        """Return a page that replays in 3-D what executions moved in a scene."""
        return self.get_scene_replay(scene)

    def execute(self, plan: str, speed: float = 1.0, title: str | None = None) -> Execution:
        """Carry out a plan in simulation, `speed` times as fast as real time."""
        return self.create_execution({"plan": plan, "speed": speed, "title": title})

    def execution(self, execution: str) -> Execution:
        """Return how far an execution is."""
        return self.get_execution(execution)

    def execution_events(self, execution: str, after: str | None = None) -> Iterator[Event]:
        """Yield what happens to an execution, until it is over."""
        return self._raw_events("/v1/executions/{job}/events", execution, after)

    def _raw_events(self, path: str, job: str, after: str | None) -> Iterator[Event]:
        call = Call("GET", path, inserted={"job": job}, headers={"Last-Event-ID": after})
        return self.ask_raw_events(call)
