"""WorkerProcess: the server's handle of one process that runs tasks."""

import asyncio
import os
import signal
import socket
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any

from service.jobs.worker.forkserver import kill_forkserver, replace_forkserver
from service.jobs.worker.main import Terms, serve
from service.jobs.worker.protocol import HEADER_SIZE, Message, unpack_header

# multiprocessing's bookkeeping of children is not thread-safe, and starting one takes
# milliseconds: one thread of its own does all of it.
_PROCESSES = ThreadPoolExecutor(1, "worker-processes")
# A forkserver that has not made a process by then says nothing any more; before its first one it
# imports what all of them need. A process that is not ready so long after that never will be [s].
LONGEST_START = 120.0
type _Streams = tuple[asyncio.StreamReader, asyncio.StreamWriter]
# A process that has closed its end is about to end; one that does not is made to.
_LINGER = 0.5


class WorkerProcess:
    """A process at the other end of a socket, watched until it ends."""

    def __init__(self, process: Any, lifeline: Any, streams: _Streams) -> None:
        """Watch a process that has been started; use `start`."""
        self.pid: int = process.pid
        self.ended = asyncio.Event()
        self.exit_code: int | None = None
        self._process = process
        self._lifeline = lifeline
        self._is_gone = False
        self._reader, self._writer = streams
        self._reaping: asyncio.Task[None] | None = None
        self._sentinel: int = process.sentinel
        asyncio.get_running_loop().add_reader(self._sentinel, self._on_exit)

    @classmethod
    async def start(
        cls, context: Any, folder: Path | None, warm_up: str | None, terms: Terms
    ) -> "WorkerProcess":
        """Start a process; it is ready once it has sent its first message.

        Raises:
            OSError: There are no more processes or files to be had.
            EOFError: The forkserver died, or said nothing and was ended.
        """
        near, far = socket.socketpair()
        held, lifeline = context.Pipe(duplex=False)
        try:
            process = context.Process(
                target=serve,
                args=(far, held, folder, warm_up, terms),
                daemon=True,
                name="wayproof-worker",
            )
            await _started(process)
            # Before it is watched: what has ended already is looked after with its writer.
            streams = await asyncio.open_unix_connection(sock=near)
        except BaseException:
            near.close()
            lifeline.close()
            raise
        finally:
            far.close()
            held.close()
        return cls(process, lifeline, streams)

    def send(self, message: Message) -> None:
        """Send a message; to a process that is gone it is lost."""
        if not self._is_gone:
            self._writer.write(message.packed())

    async def receive(self) -> Message | None:
        """Return the next message, None once the process is gone."""
        try:
            header = await self._reader.readexactly(HEADER_SIZE)
            length, kind, token = unpack_header(header)
            return Message(kind, token, await self._reader.readexactly(length))
        except (asyncio.IncompleteReadError, ConnectionError, ValueError):
            return None

    def kill(self) -> None:
        """End the process now, whatever it does."""
        if not self._is_gone:
            with suppress(ProcessLookupError):
                os.kill(self.pid, signal.SIGKILL)

    async def end(self) -> int | None:
        """Wait until the process has ended, make it if need be, and return its exit code."""
        try:
            async with asyncio.timeout(_LINGER):
                await self.ended.wait()
        except TimeoutError:
            self.kill()
            await self.ended.wait()
        return self.exit_code

    def _on_exit(self) -> None:
        self._is_gone = True
        loop = asyncio.get_running_loop()
        loop.remove_reader(self._sentinel)
        self._reaping = loop.create_task(self._reap())

    async def _reap(self) -> None:
        # If it is the forkserver that died, the process still runs: the lifeline ends it.
        self._lifeline.close()
        loop = asyncio.get_running_loop()
        try:
            self.exit_code = await loop.run_in_executor(_PROCESSES, _joined, self._process)
            self._writer.close()
            with suppress(OSError):
                await self._writer.wait_closed()
        finally:
            self.ended.set()  # also for those who wait while a loop that failed cancels all


async def _started(process: Any) -> None:
    """Start a process; end the forkserver if that does not do it, for every start waits for it."""
    loop = asyncio.get_running_loop()
    limit = loop.call_later(LONGEST_START, kill_forkserver)
    try:
        await loop.run_in_executor(_PROCESSES, process.start)
    finally:
        limit.cancel()


async def leave_forkserver(pid: int | None) -> None:
    """Have the next process forked off a new forkserver, if the present one is of that number."""
    loop = asyncio.get_running_loop()
    await loop.run_in_executor(_PROCESSES, replace_forkserver, pid)


def _joined(process: Any) -> int | None:
    process.join()
    code: int | None = process.exitcode
    process.close()
    return code
