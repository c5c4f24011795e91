"""The studio's process: viser on a loopback port, and a session for each browser.

What starts it passes browsers on, with a token that only the two know: a page on the same machine
that finds the port gets nothing. It ends when its stdin is closed.
"""

import argparse
import hmac
import io
import json
import os
import sys
import warnings
from contextlib import redirect_stdout
from pathlib import Path

import viser

from service.studio.front import HOST_HEADER, KEY_VARIABLE, TOKEN_HEADER, TOKEN_VARIABLE
from service.studio.session import Session, Terms

# Behind the server's own work.
_NICENESS = 5


def main() -> None:
    """Serve until stdin is closed."""
    parser = argparse.ArgumentParser(prog="python -m service.studio")
    parser.add_argument("--server", required=True)
    parser.add_argument("--scenes", required=True, type=Path)
    options = parser.parse_args()
    os.nice(_NICENESS)
    token = os.environ.pop(TOKEN_VARIABLE)
    # What a browser is told that has just left is lost, and that is all.
    warnings.filterwarnings("ignore", message="Queued a .* on a closed connection")
    terms = Terms(options.server, options.scenes, os.environ.pop(KEY_VARIABLE, None))
    with redirect_stdout(io.StringIO()):  # viser says where it is, which only our parent may know
        studio = viser.ViserServer("127.0.0.1", 0, verbose=False)
    sessions: dict[int, Session] = {}

    @studio.on_client_connect
    def _(client: viser.ClientHandle) -> None:
        # Viser does not say with what headers a browser came.
        connection = studio._websock_server._live_connections[client.client_id]  # noqa: SLF001  # pyright: ignore[reportPrivateUsage]
        headers = connection.request.headers if connection.request is not None else {}
        if not hmac.compare_digest(headers.get(TOKEN_HEADER, ""), token):
            return
        sessions[client.client_id] = Session(client, terms, headers[HOST_HEADER])

    @studio.on_client_disconnect
    def _(client: viser.ClientHandle) -> None:
        session = sessions.pop(client.client_id, None)
        if session is not None:
            session.close()

    sys.stdout.write(json.dumps({"port": studio.get_port()}) + "\n")
    sys.stdout.flush()
    while os.read(sys.stdin.fileno(), 4096):
        pass
    os._exit(0)  # viser's threads wait for nothing that is still there


if __name__ == "__main__":
    main()
