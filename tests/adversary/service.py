"""The service in this process, for what only it does: keep scenes and send samples."""

import tempfile
import warnings
from pathlib import Path
from typing import Any

from service.app import create_app
from service.settings import Settings
from tests.adversary.cases import Outcome

with warnings.catch_warnings():
    # Starlette wants a client that is not among our dependencies yet.
    warnings.simplefilter("ignore")
    from starlette.testclient import TestClient


_RUNNING: list[tuple[Any, Any]] = []


def _client() -> Any:
    if not _RUNNING:
        folder = tempfile.TemporaryDirectory()
        client = TestClient(create_app(Settings(engine="inline", data_dir=Path(folder.name))))
        _RUNNING.append((client.__enter__(), folder))
    return _RUNNING[0][0]


def close() -> None:
    """Stop the service, if it runs."""
    while _RUNNING:
        client, folder = _RUNNING.pop()
        client.__exit__(None, None, None)
        folder.cleanup()


def ask(method: str, path: str, body: Any) -> tuple[int, Any]:
    """Return status and answer of a request."""
    answer = _client().request(method, path, json=body)
    return answer.status_code, answer.json() if answer.content else None


def post_scene(document: Any, outcome: Outcome) -> str | None:
    """Return the id of a scene that was posted; None, and told as an error, if it is refused."""
    status, scene = ask("POST", "/v1/scenes", document)
    if status >= 300:
        outcome.blame("error", f"{status}: {scene.get('detail')}")
        return None
    return str(scene["id"])
