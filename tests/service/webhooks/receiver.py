"""A real HTTP server that webhooks lead to."""

import threading
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from tests.service.servers import until


@dataclass
class Receiver:
    """What was posted, and what is answered.

    Attributes:
        url: Where it listens.
        posts: Headers (in small letters) and bodies, in the order in which they came.
        answers: Statuses of the next answers; 200 once there are none left.
    """

    url: str = ""
    posts: list = field(default_factory=list)
    answers: list = field(default_factory=list)
    lock: threading.Lock = field(default_factory=threading.Lock)

    def wait_for(self, count):
        """Wait until so many posts have come, and return them."""
        until(lambda: len(self.posts) >= count)
        return list(self.posts)


@contextmanager
def receiver():
    """Run a server on a free port of this machine."""
    told = Receiver()

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self):
            body = self.rfile.read(int(self.headers["content-length"]))
            with told.lock:
                headers = {name.lower(): value for name, value in self.headers.items()}
                told.posts.append((headers | {":path": self.path}, body))
                status = told.answers.pop(0) if told.answers else 200
            self.send_response(status)
            if status in {301, 302, 307, 308}:
                self.send_header("Location", f"{told.url}/elsewhere")
            self.send_header("Content-Length", "0")
            self.end_headers()

        def log_message(self, *_):
            pass

    server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    told.url = f"http://127.0.0.1:{server.server_port}"
    thread = threading.Thread(target=server.serve_forever, args=(0.02,))
    thread.start()
    try:
        yield told
    finally:
        server.shutdown()
        server.server_close()
        thread.join()
