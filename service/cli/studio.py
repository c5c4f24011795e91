"""wayproof studio: the page of a server, from this machine: for servers without one."""

import os
import webbrowser
from typing import Annotated

import typer
import uvicorn
from starlette.applications import Starlette

from planning import bundled_folder
from service.api.middleware.host_check import HostCheck
from service.api.middleware.response_headers import ResponseHeaders
from service.cli.connections import MAX_MESSAGE_BYTES
from service.cli.private_server import KEY_VARIABLE
from service.cli.serve import bind, url_of
from service.settings import Settings
from service.studio import front
from service.studio.process import StudioProcess

_PORT = 8471
_MISSING = "the studio needs the extra `studio`: pip install 'wayproof[studio]'"


def studio(
    server: Annotated[str, typer.Argument(help="URL of a running server.")],
    *,
    port: Annotated[int, typer.Option(help="Port to listen on; 0 for a free one.")] = _PORT,
    open_page: Annotated[bool, typer.Option("--open", help="Open the page in a browser.")] = False,
) -> None:
    """Look at the scenes of a server, plan and execute, in a browser on this machine.

    It asks with the key in WAYPROOF_API_KEY; without one, the page asks for a key if need be.
    """
    if not front.is_available():
        typer.echo(_MISSING, err=True)
        raise typer.Exit(1)
    process = StudioProcess(server, bundled_folder("scenes"), os.environ.get(KEY_VARIABLE))
    app = Starlette()
    front.install(app, process.upstream, is_server=False)
    # Only this machine can reach it, and no page but its own.
    settings = Settings(host="127.0.0.1", allowed_hosts=None, allowed_origins=())
    app.add_middleware(HostCheck, settings=settings)
    app.add_middleware(ResponseHeaders)
    config = uvicorn.Config(
        app,
        log_config=None,
        ws="wsproto",
        ws_max_size=MAX_MESSAGE_BYTES,
        timeout_graceful_shutdown=1,
    )
    with bind(settings.host, port) as bound:
        bound.listen()  # who opens the page now waits for the server to take it
        url = url_of(bound)
        typer.echo(f"the studio of {server} is at {url}", err=True)
        if open_page:
            webbrowser.open(url)
        uvicorn.Server(config).run(sockets=[bound])
