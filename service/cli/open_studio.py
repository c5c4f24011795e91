"""open_studio(): the page of a server that runs, in a browser of this machine."""

import threading
import webbrowser
from contextlib import suppress

from service.cli.output import error_console


def open_studio(url: str, *, stays: bool) -> None:
    """Say where the studio is, and open it in a browser, if there is one.

    Args:
        url: Of the server.
        stays: Whether to wait for Ctrl-C: the server is one's own, and ends with this process.
    """
    ends = ", until Ctrl-C" if stays else ""
    error_console.print(f"the studio is at {url}{ends}", markup=False, soft_wrap=True)
    webbrowser.open(url)
    if stays:
        with suppress(KeyboardInterrupt):
            threading.Event().wait()
