"""Users for locust, which runs this file: each asks as fast as it is answered.

`locust` is a process of its own, because it replaces Python's sockets and threads by gevent's.
"""

import json
import os
import time

from locust import FastHttpUser, constant_pacing, task

# What `loads.py` says they ask for, and for how long [s].
_PLAN = os.environ["WAYPROOF_BENCH_PLAN"]
_REQUEST = json.loads(os.environ["WAYPROOF_BENCH_REQUEST"])
_PERIOD = float(os.environ.get("WAYPROOF_BENCH_PERIOD", "1"))
_SECONDS = float(os.environ["WAYPROOF_BENCH_SECONDS"])


class Timed(FastHttpUser):
    """Asks for so long; locust's own limit begins with its imports, which take seconds."""

    abstract = True

    def on_start(self) -> None:
        """Begin to count."""
        self.until = time.monotonic() + _SECONDS

    def look(self) -> None:
        """End everything in time."""
        if time.monotonic() > self.until:
            self.environment.runner.quit()


class Polls(Timed):
    """Looks at a plan that has ended."""

    @task
    def poll(self) -> None:
        """Ask once."""
        self.look()
        self.client.get(_PLAN, name="poll")


class Crowd(Polls):
    """Looks at a plan that has ended, every few seconds."""

    wait_time = constant_pacing(_PERIOD)


class Plans(Timed):
    """Asks for a plan of milliseconds and waits for it; each is a durable job."""

    @task
    def plan(self) -> None:
        """Ask once."""
        self.look()
        path = "/v1/plans?wait=30"
        with self.client.post(path, json=_REQUEST, name="plan", catch_response=True) as answer:
            if answer.status_code != 200 or answer.json()["state"] != "succeeded":
                answer.failure(f"{answer.status_code}: {(answer.text or '')[:80]}")
