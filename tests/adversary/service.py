"""The service in this process, for what only it does: keep scenes and send samples."""

import tempfile
import warnings
from pathlib import Path
from typing import Any

from service.app import create_app
from service.settings import Settings

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
