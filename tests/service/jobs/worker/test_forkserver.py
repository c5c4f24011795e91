"""A forkserver begins as a copy; one whose children die, or that says nothing, is replaced."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.service.jobs.worker.test_process_worker import is_alive
from tests.service.servers import until

# In a process of its own: there is one forkserver for each, and what it has imported stays.
BEGIN = """
import asyncio, multiprocessing.forkserver, os, signal, sys
from service.jobs.worker import process
from service.jobs.worker.main import Terms
from service.jobs.worker.process_worker import ProcessWorker
from tests.service.jobs.worker.test_process_worker import is_alive, pid_of

TASKS = ["tests.service.jobs.fake_tasks"]

async def opened(preload):
    worker = ProcessWorker(preload, Terms())
    await worker.open(None)
    await worker.ready()
    return worker

def forkserver_pid():
    return multiprocessing.forkserver._forkserver._forkserver_pid

async def story():
    async with asyncio.timeout(120):
        await told()
"""
END = """
if __name__ == "__main__":
    asyncio.run(story())
    print("done")
"""
CHILDREN_DIE = """
async def told():
    preload = [*TASKS, "tests.service.jobs.worker.bad_forkserver"]
    first = await opened(preload)
    pid, former = await pid_of(first), forkserver_pid()
    others = [await opened(preload) for _ in range(3)]
    assert forkserver_pid() != former
    assert await pid_of(first) == pid and is_alive(former)
    pids = {await pid_of(each) for each in others}
    assert len(pids) == 3
    later = forkserver_pid()
    os.kill(pid, signal.SIGKILL)
    while (now := await pid_or_none(first)) in {pid, None}:
        await asyncio.sleep(0.01)
    assert forkserver_pid() == later
    for each in (first, *others):
        await each.close()
    while is_alive(former):  # which ends with its last process
        await asyncio.sleep(0.01)

async def pid_or_none(worker):
    try:
        return await pid_of(worker)
    except AssertionError:
        return None
"""
IT_HANGS = """
async def told():
    first = await opened(TASKS)
    former = forkserver_pid()
    process.LONGEST_START = 1.0
    os.kill(former, signal.SIGSTOP)
    second = await opened(TASKS)
    assert forkserver_pid() != former and not is_alive(former)
    await first.ready()
    assert await pid_of(first) != await pid_of(second)
    await first.close()
    await second.close()
"""
# Begun where `wayproof serve` begins it: before anything else, in a process of one thread.
IT_IS_A_COPY = """
from pathlib import Path
from service.jobs.worker.forkserver import start_forkserver
from service.workers import COMMON

async def told():
    own = os.listdir("/proc/self/task")
    assert len(own) == 1, own  # a fork has no other threads
    assert not {"pydrake", "ompl", "fastapi"} & set(sys.modules)
    copy, own = (Path(f"/proc/{pid}/cmdline").read_bytes() for pid in (first, os.getpid()))
    assert copy == own
    worker = await opened(TASKS)
    assert forkserver_pid() == first
    pid, generation = await pid_of(worker), worker.generation
    os.kill(first, signal.SIGKILL)
    # Its end is heard of a moment after it: until then it is taken for ready.
    while is_alive(first) or is_alive(pid) or worker.generation == generation:
        await asyncio.sleep(0.01)
    await worker.ready()
    assert forkserver_pid() != first and await pid_of(worker) != pid
    await worker.close()

if __name__ == "__main__":
    start_forkserver(TASKS, COMMON)
    first = forkserver_pid()
    start_forkserver(TASKS, COMMON)
    assert forkserver_pid() == first
"""
# A loop that fails cancels all that runs in it, at whatever that is.
IT_FAILS = """
import time

async def told():
    worker = await opened(TASKS)
    pid, joined = await pid_of(worker), process._joined

    def slowly(ended):
        time.sleep(1.0)
        return joined(ended)

    process._joined = slowly
    os.kill(pid, signal.SIGKILL)
    while is_alive(pid):
        await asyncio.sleep(0.01)
    await asyncio.sleep(0.2)
    raise RuntimeError("on purpose")
"""
# Its end is that of the last process which can ask it for another one, however that ends.
IT_IS_LEFT = """
from service.jobs.worker.forkserver import start_forkserver
from service.workers import COMMON

if __name__ == "__main__":
    start_forkserver(TASKS, COMMON)
    print(forkserver_pid(), flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.parametrize(
    "story",
    [CHILDREN_DIE, IT_HANGS, IT_IS_A_COPY],
    ids=["children_die", "it_hangs", "it_is_a_copy"],
)
def test_a_bad_forkserver_is_replaced(story, tmp_path):
    ended = told(BEGIN + story + END, tmp_path)
    assert ended.stdout == "done\n", ended.stderr[-2000:]


def test_a_copy_ends_with_the_process_that_it_is_a_copy_of(tmp_path):
    ended = told(BEGIN + IT_IS_LEFT, tmp_path)
    until(lambda: not is_alive(int(ended.stdout)))


def test_a_loop_that_fails_while_a_process_is_looked_after_ends(tmp_path):
    ended = told(BEGIN + IT_FAILS + END, tmp_path)
    assert "on purpose" in ended.stderr
    assert not ended.stdout


def told(story, tmp_path):
    """Run a script in a process of its own."""
    script = tmp_path / "story.py"
    script.write_text(story, encoding="utf-8")
    variables = {"BAD_FORKSERVER": str(tmp_path / "mark"), "PYTHONPATH": str(Path.cwd())}
    return subprocess.run(
        [sys.executable, str(script)],
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
        timeout=200,
        check=False,
    )
