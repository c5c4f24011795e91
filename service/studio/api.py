"""Api: what the studio asks a server, as numbers that can be drawn."""

import functools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, override

import httpx
import numpy as np
from pydantic import ConfigDict, Field

from service.client.client import Client
from service.client.errors import ApiError
from service.client.events import Event
from service.client.models import Answer, Execution, Plan
from service.studio.motions.series import Series, SeriesAnswer
from service.studio.numbers import Array
from wayproof_client.call import Call

# Frames that one question may name, and configurations.
_MAX_ROWS = 10_000
# What a plan was asked that its motion is held to again.
_HELD_TO = (
    "tool_limits",
    "speed_zones",
    "acceleration_bounds",
    "effort",
    "payload",
    "velocity_scale",
    "acceleration_scale",
)


class Limits(Answer):
    """Of a group, per position."""

    lower: list[float | None]
    upper: list[float | None]


class ShownGroup(Answer):
    """A group that can be shown and moved."""

    name: str
    joints: list[dict[str, Any]] = Field(default_factory=list)  # with their `type`
    position_names: list[str]
    tool_frames: list[str]
    configurations: dict[str, list[float]]
    limits: Limits
    positions: list[float]


class ShownScene(Answer):
    """A scene that can be shown."""

    model_config = ConfigDict(extra="allow")

    id: str
    name: str
    revision: int
    frames: list[str]
    groups: list[ShownGroup]
    document: dict[str, Any]

    def group(self, name: str) -> ShownGroup:
        """Return a group by its name."""
        return next(group for group in self.groups if group.name == name)


class ByName(httpx.HTTPTransport):
    """Asks a server by another name than its address: the one that the browser knows it by."""

    def __init__(self, host: str) -> None:
        super().__init__()
        self._host = host

    @override
    def handle_request(self, request: httpx.Request) -> httpx.Response:
        request.headers["Host"] = self._host
        return super().handle_request(request)


def evidence_of(fault: ApiError) -> dict[str, Any]:
    """Return the evidence of a problem as the server sent it."""
    evidence: Any = getattr(fault.problem, "evidence", None) or {}
    return evidence if isinstance(evidence, dict) else evidence.model_dump()


class Api(Client):
    """A client with the questions of the studio."""

    @functools.cached_property
    def document(self) -> dict[str, Any]:
        """What can be asked: the server's OpenAPI document."""
        found: dict[str, Any] = self._json("GET", "/openapi.json")
        return found

    @functools.cached_property
    def planner_names(self) -> list[str]:
        """Names of the planners that a plan may name."""
        return [planner["name"] for planner in self._json("GET", "/v1/planners")["items"]]

    def scenes(self) -> list[dict[str, Any]]:
        """Return the newest scenes of the server: `id`, `name`, `revision`."""
        found: list[dict[str, Any]] = self._json("GET", "/v1/scenes", query={"limit": 50})["items"]
        return found

    def shown(self, scene: str) -> ShownScene:
        """Return a scene as it is now."""
        return ShownScene.model_validate(self._json("GET", f"/v1/scenes/{scene}"))

    def geometry(self, scene: str) -> list[dict[str, Any]]:
        """Return what the bodies of a scene look like."""
        found: list[dict[str, Any]] = self._json("GET", f"/v1/scenes/{scene}/geometry")["bodies"]
        return found

    def mesh(self, scene: str, sha256: str) -> bytes:
        """Return a mesh (binary glTF, z up)."""
        return self.send(Call("GET", f"/v1/scenes/{scene}/geometry/{sha256}.glb")).content

    def poses(
        self, scene: str, group: str, configurations: Array, frames: Sequence[str]
    ) -> dict[str, Array]:
        """Return where frames are: X_WF as position and quaternion [w, x, y, z], shape (n, 7)."""
        if not frames:
            return {}
        body = {
            "group": group,
            "configurations": np.atleast_2d(configurations)[:_MAX_ROWS].tolist(),
            "frames": list(frames),
        }
        results = self._json("POST", f"/v1/scenes/{scene}/fk", body)["results"]
        return {
            frame: np.array([
                [*row[frame]["position"], *row[frame]["quaternion"]] for row in results
            ])
            for frame in frames
        }

    def ik(self, scene: str, group: str, goal: dict[str, Any], start: Array) -> dict[str, Any]:
        """Return a few configurations that reach a goal, nearest first, or why there is none."""
        body = {
            "group": group,
            "goal": goal,
            "start": start.tolist(),
            "ik": {"max_configurations": 6, "max_trials": 60},
            "allowed_time": 1.0,
        }
        found: dict[str, Any] = self._json("POST", f"/v1/scenes/{scene}/ik", body)
        return found

    def check(self, scene: str, group: str, configurations: Array) -> list[dict[str, Any]]:
        """Return a verdict per configuration, with all pairs that collide and the nearest one."""
        body = {"group": group, "configurations": np.atleast_2d(configurations).tolist()}
        found: list[dict[str, Any]] = self._json("POST", f"/v1/scenes/{scene}/check", body)[
            "results"
        ]
        return found

    def finished_plan(self, plan: str) -> dict[str, Any]:
        """Return a plan with all of its result."""
        found: dict[str, Any] = self._json("GET", f"/v1/plans/{plan}")
        return found

    def succeeded_plans(self, scene: str, most: int) -> list[str]:
        """Return ids of the newest plans of a scene that succeeded, newest first."""
        query = {"scene": scene, "state": "succeeded", "limit": most}
        return [item["id"] for item in self._json("GET", "/v1/plans", query=query)["items"]]

    def series(self, plan: str) -> Series:
        """Return what the motion of a plan does over time."""
        return Series(SeriesAnswer.model_validate(self._json("GET", f"/v1/plans/{plan}/series")))

    def graph(self, plan: str) -> dict[str, Any]:
        """Return what the planner of a plan explored."""
        found: dict[str, Any] = self._json("GET", f"/v1/plans/{plan}/graph")
        return found

    def live_states(self, scene: str, rate: float) -> Iterator[dict[str, Any]]:
        """Yield the live state of a scene, now and whenever it changes; ends with the scene."""
        path = "/v1/scenes/{scene}/state/events"
        call = Call("GET", path, inserted={"scene": scene}, query={"rate": rate})
        for event in self.ask_raw_events(call):
            yield event.data

    def certify_again(self, job: Mapping[str, Any], revision: int) -> dict[str, Any]:
        """Return the certificate of a plan's exact motion in another revision of its scene.

        Args:
            job: The plan, with its request and its result.
            revision: Of the scene.
        """
        asked = job["request"]
        motion = self._json(
            "GET", f"/v1/plans/{job['id']}/trajectory", query={"polynomial": "true"}
        )
        checks = job["result"]["certificate"]["checks"]
        body: dict[str, Any] = {
            **{name: asked["retime"][name] for name in _HELD_TO},
            **{name: asked[name] for name in ("scene", "group", "path_constraints", "margin")},
            "limit_jerk": any(check["name"] == "jerk" for check in checks),
            "revision": revision,
            "trajectory": motion,
        }
        found: dict[str, Any] = self._json("POST", "/v1/trajectories/certify", body)
        return found["certificate"]

    def control(self, execution: str, what: str, **body: float) -> None:
        """Pause, resume, cancel an execution, or set its speed."""
        self._json("POST", f"/v1/executions/{execution}/{what}", body or None)

    def _json(
        self, method: str, path: str, body: Any = None, query: Mapping[str, Any] | None = None
    ) -> Any:
        """Return an answer as it is: of long ones the studio reads a little."""
        return self.send(Call(method, path, query=query or {}, body=body)).json()


__all__ = ["Api", "ByName", "Event", "Execution", "Iterator", "Plan", "ShownScene", "evidence_of"]
