"""Asking: what scenarios ask a server over HTTP, in the words of its interface."""

from pathlib import Path
from typing import Any

import httpx
import yaml

_ROOT = Path(__file__).resolve().parents[2]
_LONGEST = 120.0
DOWN = [3.141592653589793, 0.0, 0.0]


class Asking:
    """Asks one server.

    Attributes:
        http: Asks it.
        url: Of it.
    """

    def __init__(self, url: str, headers: dict[str, str] | None = None) -> None:
        """Speak to the server at a URL, with further headers in each request."""
        self.url = url
        self.http = httpx.Client(
            base_url=url, timeout=_LONGEST, trust_env=False, headers=headers or {}
        )

    def json(self, method: str, path: str, body: Any = None) -> Any:
        """Return the JSON of an answer, whatever it is."""
        return self.http.request(method, path, json=body).json()

    def done(self, method: str, path: str, body: Any = None) -> Any:
        """Return the JSON of an answer.

        Raises:
            RuntimeError: It is a refusal.
        """
        answer = self.http.request(method, path, json=body)
        if not answer.is_success:
            message = f"{method} {path}: {answer.text[:500]}"
            raise RuntimeError(message)
        return answer.json()

    def scene(self, document: dict[str, Any]) -> str:
        """Post a scene and return its id."""
        return str(self.done("POST", "/v1/scenes", document)["id"])

    def edited(self, scene: str, *operations: dict[str, Any]) -> Any:
        """Edit a scene and return what the edit says."""
        return self.done("PATCH", f"/v1/scenes/{scene}", {"operations": list(operations)})

    def planned(self, request: dict[str, Any]) -> Any:
        """Return a plan that succeeded.

        Raises:
            RuntimeError: It failed.
        """
        plan = self.done("POST", "/v1/plans?wait=60", {"seed": 7, **request})
        if plan["state"] != "succeeded":
            message = f"the plan failed: {plan['failure']}"
            raise RuntimeError(message)
        return plan

    def executed(self, body: dict[str, Any]) -> Any:
        """Return an execution that has ended."""
        return self.done("POST", "/v1/executions?wait=60", body)

    def ended(self, execution: str) -> Any:
        """Return an execution once it has ended."""
        with self.http.stream("GET", f"/v1/executions/{execution}/events") as events:
            for _ in events.iter_lines():
                pass
        return self.done("GET", f"/v1/executions/{execution}")

    def moving(self, execution: str, time: float = 0.0) -> None:
        """Wait until an execution is beyond a time of its motion [s]."""
        path = f"/v1/executions/{execution}"
        while not (status := self.done("GET", path)["status"]) or status["time"] <= time:
            pass

    def reaching(self, scene: str, group: str, position: list[float], rpy: Any = None) -> Any:
        """Return positions with the tool at a place, looking down."""
        pose = {"position": position, "rpy": rpy or DOWN}
        body = {
            "group": group,
            "goal": {"type": "pose", "poses": [pose]},
            "ik": {"max_configurations": 1},
            "seed": 1,
        }
        found = self.done("POST", f"/v1/scenes/{scene}/ik", body)
        return found["configurations"][0]["positions"]


def bundled(name: str) -> dict[str, Any]:
    """Return the document of a bundled scene."""
    text = (_ROOT / "scenes" / f"{name}.scene.yaml").read_text(encoding="utf-8")
    document: dict[str, Any] = yaml.safe_load(text)
    return document
