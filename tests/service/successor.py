"""What comes after a server that was killed: the service in this process, on the records it left.

It starts in a tenth of the time. `make campaign` starts a process, as users do.
"""

from contextlib import contextmanager
from dataclasses import dataclass

import httpx

from service.app import create_app
from service.client.client import Client
from service.settings import Settings
from tests.profiles import PROFILE
from tests.service.conftest import TestClient
from tests.service.servers import server


class _InProcess(httpx.BaseTransport):
    """Hands requests to an application here; answers are whole when they come."""

    def __init__(self, app):
        self._app = app

    def handle_request(self, request):
        sent = {"content": request.read(), "headers": dict(request.headers)}
        answer = self._app.request(request.method, str(request.url), **sent)
        headers = {"content-type": answer.headers.get("content-type", "")}
        return httpx.Response(answer.status_code, headers=headers, content=answer.content)


@dataclass(frozen=True)
class Successor:
    """The service, and a client of it."""

    app: TestClient
    client: Client

    def ask(self, method, path, body=None):
        """The JSON of an answer that is no problem."""
        answer = self.app.request(method, path, json=body)
        assert answer.is_success, answer.text
        return answer.json()


@contextmanager
def successor(folder, **environment):
    """The service on the records in `folder`."""
    if PROFILE.is_campaign:
        with server(folder, **environment) as running:
            yield running
        return
    settings = Settings(engine="inline", data_dir=folder / "state", query_timeout=300)
    with (
        TestClient(create_app(settings)) as app,
        Client("http://testserver", transport=_InProcess(app)) as client,
    ):
        yield Successor(app, client)
