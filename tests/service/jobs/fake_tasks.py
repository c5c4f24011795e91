"""Tasks that behave, hang, crash and lie."""

import contextlib
import ctypes
import gc
import os
import signal
import socket
import threading
import time
from pathlib import Path
from typing import Any

from pydantic import JsonValue, RootModel

from planning.errors import Canceled, GoalUnreachable
from planning.parallel.atomic_files import write_atomically
from service.jobs.artifacts import Artifact
from service.jobs.context import MADE, TaskContext
from service.jobs.host_folder import artifact_path, host_folder
from service.jobs.task import Task


class Payload(RootModel[dict[str, Any]]):
    """Whatever a test gives."""


class Result(RootModel[JsonValue]):
    """Whatever is JSON."""


def fake(function):
    """Declare the task `fake.<name of the function>`, which gives and takes dictionaries."""
    task = Task(f"fake.{function.__name__}", Payload, Result)

    @task.runs
    def run(work, context):
        return Result.model_validate(function(work.root, context))

    return run


@fake
def echo(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    channel.emit("stage", {"stage": "echo", "progress": 0.5})
    return {"echo": payload, "pid": os.getpid()}


@fake
def warm(_: dict[str, Any], __: TaskContext) -> dict[str, Any]:
    return {}


@fake
def connect(payload: dict[str, Any], _: TaskContext) -> dict[str, Any]:
    """Tell how it goes to reach a listener, and one of this process's own."""
    told = {"user": os.getuid()}
    for name, (family, address) in payload["listeners"].items():
        where = tuple(address) if isinstance(address, list) else address
        with socket.socket(getattr(socket, family), socket.SOCK_STREAM) as end:
            end.settimeout(5)
            try:
                end.connect(where)
            except OSError as fault:
                told[name] = fault.strerror or str(fault)
            else:
                told[name] = "reached"
    with socket.create_server(("127.0.0.1", 0)) as own:
        socket.create_connection(own.getsockname(), 5).close()
    return told


@fake
def garbage(_: dict[str, Any], __: TaskContext) -> dict[str, Any]:
    """Tell whether this process looks for garbage, and how often it, or what it is of, has."""
    looks = sum(generation["collections"] for generation in gc.get_stats())
    return {"looks": gc.isenabled(), "spared": gc.get_freeze_count() > 1000, "has_looked": looks}


@fake
def repeat(payload: dict[str, Any], _: TaskContext) -> dict[str, Any]:
    """Give the same whenever it is asked, unless a clock had a part in it."""
    return {"cut_short": payload.get("cut_short", [])}


@fake
def refuse(_: dict[str, Any], __: TaskContext) -> dict[str, Any]:
    raise GoalUnreachable("too far", {"metres": 2.0})


@fake
def blunder(_: dict[str, Any], __: TaskContext) -> dict[str, Any]:
    return {"x": {}["missing"]}


@fake
def leave(_: dict[str, Any], __: TaskContext) -> dict[str, Any]:
    raise SystemExit(3)


@fake
def interrupt(_: dict[str, Any], __: TaskContext) -> dict[str, Any]:
    raise KeyboardInterrupt


@fake
def secret(_: dict[str, Any], __: TaskContext) -> dict[str, Any]:
    return {"not JSON": {1, 2}}


@fake
def spin(_: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Run until canceled, in Python."""
    channel.emit("stage", {"stage": "spin", "progress": 0.1, "pid": os.getpid()})
    while not channel.is_canceled():
        time.monotonic()
    raise Canceled("noticed")


@fake
def hang(_: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Sleep in C with the interpreter's lock held: no signal handler, no thread can run."""
    told = {"stage": "hang", "progress": 0.1, "pid": os.getpid(), "timings": {"load": 0.125}}
    channel.emit("stage", told)
    ctypes.PyDLL(None).sleep(30)
    return {}


@fake
def reckon(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Say how long it may take, some seconds each time, and then work for some."""
    for allowed, works in payload["terms"]:
        channel.allow(allowed)
        threading.Event().wait(works)
    return {"pid": os.getpid()}


@fake
def segfault(_: dict[str, Any], __: TaskContext) -> dict[str, Any]:
    os.kill(os.getpid(), signal.SIGSEGV)
    return {}


@fake
def die_in_stage(_: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """End the process in a stage that is told."""
    channel.emit("stage", {"stage": "search", "progress": 0.2})
    os.kill(os.getpid(), signal.SIGSEGV)
    return {}


@fake
def die_once(payload: dict[str, Any], _: TaskContext) -> dict[str, Any]:
    """End the process at the first attempt, return at the second."""
    marker = Path(payload["marker"])
    if not marker.exists():
        marker.touch()
        os._exit(7)
    return {"attempt": 2}


@fake
def chatter(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    emit = channel.emit_whole if payload.get("whole") else channel.emit
    for i in range(payload["count"]):
        emit("note", {"i": i, "text": "x" * payload["size"]})
    return {}


@fake
def leave_quietly(_: dict[str, Any], __: TaskContext) -> dict[str, Any]:
    os._exit(0)


@fake
def exhaust(_: dict[str, Any], __: TaskContext) -> dict[str, Any]:
    raise MemoryError


@fake
def close_everything(_: dict[str, Any], __: TaskContext) -> dict[str, Any]:
    """Close the socket to the server, and stay."""
    os.closerange(3, 100)
    ctypes.PyDLL(None).sleep(30)
    return {}


@fake
def babble(_: dict[str, Any], __: TaskContext) -> dict[str, Any]:
    """Write noise into every descriptor, as damaged native code might."""
    for descriptor in range(3, 30):
        with contextlib.suppress(OSError):
            os.write(descriptor, b"noise" * 20)
    return {}


@fake
def touch(payload: dict[str, Any], _: TaskContext) -> dict[str, Any]:
    """Count runs in a file."""
    with Path(payload["file"]).open("a") as file:
        file.write(f"{os.getpid()}\n")
    return {}


@fake
def stubborn(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Return its result although it was canceled."""
    channel.emit("stage", {"stage": "stubborn", "pid": os.getpid()})
    while not channel.is_canceled():
        time.monotonic()
    return {"kept": payload}


@fake
def wait_for_file(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Return once a file is there; make another one first if it is named."""
    channel.emit("stage", {"stage": "wait", "pid": os.getpid()})
    if "begun" in payload:
        Path(payload["begun"]).touch()
    while not Path(payload["file"]).exists():
        os.sched_yield()
    filling = {"filling": "x" * payload["count"]} if "count" in payload else {}
    return {"pid": os.getpid(), **filling}


@fake
def vast(payload: dict[str, Any], _: TaskContext) -> dict[str, Any]:
    return {"numbers": [0.1 * i for i in range(payload["count"])], "none": float("inf")}


@fake
def move(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Say how it goes until canceled, then come to rest in some steps; obey `goal`."""
    channel.watch(payload.get("silence", 60.0))
    place = 0
    while not channel.is_canceled():
        asked = channel.controls()
        channel.update("status", {"place": place, "pid": os.getpid(), "asked": asked})
        if asked.get("goal") == place:
            return {"place": place}
        threading.Event().wait(0.005)
        place += 1
    Path(payload["rest"]).write_text(str(place))
    message = f"at rest at {place}"
    raise Canceled(message, {"place": place})


@fake
def spin_until_told(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Run until canceled, and leave a sign of each."""
    Path(payload["begun"]).touch()
    while not channel.is_canceled():
        time.monotonic()
    Path(payload["ended"]).touch()
    raise Canceled("noticed")


@fake
def read(payload: dict[str, Any], _: TaskContext) -> dict[str, Any]:
    """Tell the sizes of artifacts that are here, and in which folder."""
    paths = [artifact_path(host_folder(), digest) for digest in payload["digests"]]
    sizes = [path.stat().st_size if path.exists() else None for path in paths]
    return {"sizes": sizes, "folder": str(host_folder())}


@fake
def make(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Make artifacts of some sizes in the folder of this host, and say so."""
    contents = [bytes(size) for size in payload["sizes"]]
    digests = [Artifact(content).digest for content in contents]
    for digest, content in zip(digests, contents, strict=True):
        write_atomically(artifact_path(host_folder(), digest), content)
    channel.emit(MADE, {"artifacts": digests})
    return {"digests": digests}


@fake
def hang_quietly(payload: dict[str, Any], _: TaskContext) -> dict[str, Any]:
    """Leave a sign, and sleep in C with the interpreter's lock held."""
    Path(payload["begun"]).touch()
    ctypes.PyDLL(None).sleep(30)
    return {}


@fake
def grow(payload: dict[str, Any], channel: TaskContext) -> dict[str, Any]:
    """Take memory, `chunk` bytes at a time, up to `most`; come to rest when told to."""
    taken: list[bytes] = []
    most = payload.get("most", float("inf"))
    while not ("rest" in payload and channel.is_canceled()):
        if sum(map(len, taken)) < most:
            taken.append(b"x" * payload["chunk"])
        threading.Event().wait(0.001)
    Path(payload["rest"]).touch()
    raise Canceled("at rest")


@fake
def keep(payload: dict[str, Any], _: TaskContext) -> dict[str, Any]:
    """Take memory, and keep it."""
    _kept.append(b"x" * payload["count"])
    return {}


_kept: list[bytes] = []


@fake
def niceness(_: dict[str, Any], __: TaskContext) -> dict[str, Any]:
    return {"niceness": os.nice(0)}
