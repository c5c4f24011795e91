"""A server that joins a cluster is ended by its own handler of SIGTERM, whenever it comes.

Ray's handler is absl's: it passes the signal on, and sets an alarm that aborts the process. These
tests stand in for it with an alarm of their own, so that they need no Ray.
"""

import asyncio
import os
import signal
import threading
import time

import pytest

from service.jobs.hosts import ray_hosts
from service.jobs.hosts.ray_hosts import RayHosts

_AFTER = 1  # of the alarm [s], 3 in Ray


@pytest.fixture
def alarms():
    """Instants at which an alarm came, which would have aborted the process."""
    came = []
    before = signal.signal(signal.SIGALRM, lambda *_: came.append(time.monotonic()))
    yield came
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture
def terms():
    """Instants at which this process was told to end."""
    came = []
    before = signal.signal(signal.SIGTERM, lambda *_: came.append(time.monotonic()))
    yield came
    signal.signal(signal.SIGTERM, before)


def join(monkeypatch, join_for, told_after):
    """Join a cluster that takes some time [s], and tell this process to end meanwhile."""

    def joined(address):
        threading.Event().wait(told_after)
        os.kill(os.getpid(), signal.SIGTERM)
        threading.Event().wait(join_for - told_after)
        return address

    async def run():
        # What absl's handler does before it passes the signal on.
        inner = signal.getsignal(signal.SIGTERM)
        signal.signal(signal.SIGTERM, lambda *said: (signal.alarm(_AFTER), inner(*said)))
        address = await RayHosts("here:1")._join()
        await asyncio.sleep(_AFTER + 0.3)
        return address

    monkeypatch.setattr(ray_hosts, "_joined", joined)
    return asyncio.run(run())


@pytest.mark.parametrize(("join_for", "told_after"), [(0.3, 0.1), (2.5, 0.1), (2.5, 2.4)])
def test_no_alarm_aborts_a_server_that_was_told_to_end_while_it_joined(
    monkeypatch, alarms, terms, join_for, told_after
):
    assert join(monkeypatch, join_for, told_after) == "here:1"
    assert len(terms) == 1
    assert alarms == []


def test_a_cluster_that_lets_nobody_in_is_told(monkeypatch):
    def joined(address):
        raise ray_hosts.ConnectionLost(address)

    monkeypatch.setattr(ray_hosts, "_joined", joined)
    with pytest.raises(ray_hosts.ConnectionLost, match="here:1"):
        asyncio.run(RayHosts("here:1")._join())
