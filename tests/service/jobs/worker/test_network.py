"""A worker reaches its server and itself, and nothing else of any network."""

import asyncio
import json
import os
import socket
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest

from service.jobs.worker import network
from service.jobs.worker.main import Terms
from service.jobs.worker.network import leave_network
from tests.profiles import only_campaign
from tests.service.jobs.worker.one_worker import open_worker
from tests.service.jobs.worker.test_process_worker import run_of

# Whether this kernel has what is tested is asked of it, in a process of its own.
ASK = "from service.jobs.worker.network import leave_network; print(leave_network())"
POSSIBLE = subprocess.run([sys.executable, "-c", ASK], capture_output=True, text=True, check=True)
needs_namespaces = pytest.mark.skipif(
    POSSIBLE.stdout.strip() != "None", reason=f"here not: {POSSIBLE.stdout}"
)


@pytest.fixture
def listeners():
    """Listeners of this process, as a task finds them."""
    with ExitStack() as stack:
        plain = stack.enter_context(socket.create_server(("127.0.0.1", 0)))
        abstract = stack.enter_context(socket.socket(socket.AF_UNIX))
        abstract.bind(f"\0wayproof-{os.getpid()}")
        abstract.listen()
        yield {
            "plain": ("AF_INET", list(plain.getsockname())),
            "abstract": ("AF_UNIX", f"\0wayproof-{os.getpid()}"),
        }


def told_by_worker(terms, listeners):
    async def story():
        async with open_worker(terms) as worker:
            outcome = await worker.run(run_of("connect", listeners=listeners))
            again = await worker.run(run_of("echo"))  # the way to the server is whole
            assert json.loads(again.result.text)["echo"] == {}
            return json.loads(outcome.result.text)

    return asyncio.run(story())


def test_a_worker_that_may_reaches_what_listens(listeners):
    told = told_by_worker(Terms(), listeners)
    assert (told["plain"], told["abstract"]) == ("reached", "reached")


@needs_namespaces
def test_a_worker_that_may_not_reaches_nothing(listeners):
    told = told_by_worker(Terms(is_offline=True), listeners)
    assert (told["plain"], told["abstract"]) == ("Connection refused", "Connection refused")
    assert told["user"] == os.getuid()


OUTSIDE = """
import os, socket, sys
from service.jobs.worker.network import leave_network
if os.getuid() == 0:
    os.setgroups([]); os.setgid(65534); os.setuid(65534)
fault = leave_network()
if fault:
    print("not possible:", fault)
    sys.exit()
for address in ("192.0.2.1", "127.0.0.1"):
    try:
        socket.socket().connect((address, int(sys.argv[1])))
    except OSError as fault:
        print(fault.strerror)
"""


def test_a_user_without_rights_leaves_too(listeners):
    """Unless the kernel keeps user namespaces from it, as those of some containers do."""
    port = str(listeners["plain"][1][1])
    command = [sys.executable, "-c", OUTSIDE, port]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.stdout in {
        "Network is unreachable\nConnection refused\n",
        "not possible: network namespaces: Operation not permitted\n",
    }, done.stderr


@pytest.mark.parametrize("fault", [PermissionError(1, "Operation not permitted"), OSError(22, "x")])
def test_where_the_kernel_refuses_it_is_said(monkeypatch, fault):
    def refuse(flags):
        raise fault

    monkeypatch.setattr(network.os, "unshare", refuse)
    assert leave_network() == f"network namespaces: {fault.strerror}"
    monkeypatch.delattr(network.os, "unshare")
    assert "unshare" in leave_network()


REFUSED = """
import asyncio, json, logging, os, sys
from pathlib import Path
from service.jobs.worker.main import Terms
from tests.service.jobs.worker.one_worker import open_worker
from tests.service.jobs.worker.test_process_worker import run_of

async def story():
    for _ in range(2):
        async with open_worker(Terms(is_offline=True)) as worker:
            outcome = await worker.run(run_of("connect", listeners={"it": json.loads(sys.argv[1])}))
            print(json.loads(outcome.result.text)["it"])

# A kernel that refuses, for this process and its children: it may have no network namespaces.
user, group = os.geteuid(), os.getegid()
os.unshare(os.CLONE_NEWUSER)
Path("/proc/self/uid_map").write_text(f"0 {user} 1")
Path("/proc/sys/user/max_net_namespaces").write_text("0")
logging.basicConfig(stream=sys.stdout, format="%(message)s")
asyncio.run(story())
"""


@only_campaign("11 s")
@needs_namespaces
def test_a_worker_starts_all_the_same_and_the_log_says_it_once(listeners):
    command = [sys.executable, "-c", REFUSED, json.dumps(listeners["plain"])]
    root = Path(__file__).parents[4]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=root)
    said, *reached = done.stdout.splitlines()
    assert said.startswith("workers can reach the network (network namespaces: "), done.stderr
    assert reached == ["reached"] * 2
