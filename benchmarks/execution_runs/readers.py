"""Whether those who watch an execution make its controller late."""

import asyncio
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

from benchmarks.execution_runs.executions import QUERIES, begun, ended, planned, posted
from benchmarks.execution_runs.rows import Row
from benchmarks.service_load.host import Host

# Of a motion of some two seconds: long enough for a 99th percentile of hundreds of ticks.
_SPEED = 0.5


def readers(host: Host, counts: list[int]) -> Iterator[Row]:
    """Carry the same plan out again and again, each time with a number of readers of its events.

    Args:
        host: Of the server.
        counts: Of readers, each over a connection of its own.
    """
    name, group, wanted = QUERIES[0]
    for count in counts:
        row = Row(f"{count} readers")
        plan = planned(host, posted(host, name), group, wanted)
        execution = begun(host, plan, speed=_SPEED)
        crowd = _crowd(f"{host.url}/v1/executions/{execution}/events", count)
        done = ended(host, execution)
        told = json.loads(crowd.communicate(timeout=60)[0])
        row.note_jitter(done["status"]["jitter"])
        row.numbers["statuses a reader"] = told["statuses"] / max(1, count)
        if told["finished"] != count:
            row.faults.append(f"{told['finished']} of {count} heard of the end")
        if done["state"] != "succeeded":
            row.faults.append(done["state"])
        yield row


def _crowd(url: str, count: int) -> subprocess.Popen[bytes]:
    """Return a process with all readers, at a low priority: it is the clients' processor time."""
    command = [sys.executable, "-m", "benchmarks.execution_runs.readers", url, str(count)]
    root = Path(__file__).resolve().parents[2]
    return subprocess.Popen(command, cwd=root, stdout=subprocess.PIPE)


async def read_all(url: str, count: int) -> dict[str, int]:
    """Read a stream of events over `count` connections to its end; return what has come."""
    found = await asyncio.gather(*(_read(url) for _ in range(count)))
    return {
        "statuses": sum(text.count(b"event: status") for text in found),
        "finished": sum(b"event: finished" in text for text in found),
    }


async def _read(url: str) -> bytes:
    parts = urlsplit(url)
    reader, writer = await asyncio.open_connection(parts.hostname, parts.port)
    head = f"GET {parts.path} HTTP/1.1\r\nHost: {parts.netloc}\r\nConnection: close\r\n\r\n"
    writer.write(head.encode())
    await writer.drain()
    text = await reader.read(-1)
    writer.close()
    return text


if __name__ == "__main__":
    os.nice(10)
    print(json.dumps(asyncio.run(read_all(sys.argv[1], int(sys.argv[2])))))
