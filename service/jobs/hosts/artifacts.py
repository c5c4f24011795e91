"""Artifacts cross between the dispatcher, which has the database, and hosts.

A host asks for what it lacks before a run; the dispatcher asks for what a run has made before it
says that the run has ended. Answers come in pieces, which let what is urgent go before.
"""

import asyncio
import itertools
import json
import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from anyio import to_thread

from service.jobs.artifacts import ArtifactSource
from service.jobs.host_folder import artifact_path
from service.jobs.hosts.messages import HostMessage, HostMessageKind
from service.jobs.json_text import encode

# What is sent of an answer at once [bytes].
_PIECE = 1024 * 1024
# Before a database that did not answer is asked again [s].
_PAUSE = 1.0
_log = logging.getLogger(__name__)

type Send = Callable[[HostMessage], None]


class FolderArtifacts:
    """Artifacts that tasks have made in the folder of a host; they have no parts of their own."""

    def __init__(self, folder: Path) -> None:
        """Read them from `folder`."""
        self._folder = folder

    async def parts(self, digests: Sequence[str]) -> Mapping[str, tuple[str, ...]]:
        """Return that none needs another one."""
        return dict.fromkeys(digests, ())

    async def contents(self, digests: Sequence[str]) -> Mapping[str, bytes]:
        """Return the bytes of artifacts, as far as they are there."""
        return await to_thread.run_sync(self._contents, digests)

    def _contents(self, digests: Sequence[str]) -> dict[str, bytes]:
        paths = {digest: artifact_path(self._folder, digest) for digest in digests}
        return {digest: path.read_bytes() for digest, path in paths.items() if path.is_file()}


class RemoteArtifacts:
    """What the other end has of artifacts, asked for by messages."""

    def __init__(self, send: Send) -> None:
        """Ask by `send`."""
        self._send = send
        self._numbers = itertools.count(1)
        self._pieces: dict[int, list[bytes]] = {}
        self._answers: dict[int, asyncio.Future[bytes]] = {}

    async def parts(self, digests: Sequence[str]) -> Mapping[str, tuple[str, ...]]:
        """Return which artifacts are needed with each of some, as far as they are stored."""
        answer = await self._ask({"parts": list(digests)})
        return {digest: tuple(parts) for digest, parts in json.loads(answer).items()}

    async def contents(self, digests: Sequence[str]) -> Mapping[str, bytes]:
        """Return the bytes of artifacts, as far as they are stored."""
        answer = await self._ask({"contents": list(digests)})
        place = answer.index(b"\n")
        sizes: dict[str, int] = json.loads(answer[:place])
        found: dict[str, bytes] = {}
        place += 1
        for digest, size in sizes.items():
            found[digest] = answer[place : place + size]
            place += size
        return found

    def take(self, message: HostMessage) -> None:
        """Take a piece of an answer; the first byte of the last one is 0."""
        pieces = self._pieces.get(message.run)
        if pieces is None:
            return  # it is not waited for any more
        pieces.append(message.body[1:])
        answer = self._answers[message.run]
        if message.body[:1] == b"\0" and not answer.done():
            answer.set_result(b"".join(pieces))

    async def _ask(self, question: Mapping[str, list[str]]) -> bytes:
        number = next(self._numbers)
        answer = self._answers[number] = asyncio.get_running_loop().create_future()
        self._pieces[number] = []
        body = encode(question).encode()
        self._send(HostMessage(HostMessageKind.ASK, 0, number, body))
        try:
            return await answer
        finally:
            del self._answers[number], self._pieces[number]


class ArtifactAnswers:
    """Answers what the other end asks about artifacts."""

    def __init__(self, source: ArtifactSource | None) -> None:
        """Answer from `source`; None where nothing is stored."""
        self._source = source
        self._tasks: set[asyncio.Task[None]] = set()

    def take(self, message: HostMessage, send: Send) -> None:
        """Answer a question, once the database does, by `send`."""
        task = asyncio.get_running_loop().create_task(self._answer(message, send))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def forget(self) -> None:
        """Answer nothing any more of what was asked."""
        for task in self._tasks:
            task.cancel()

    async def _answer(self, message: HostMessage, send: Send) -> None:
        question = json.loads(message.body)
        while True:
            try:
                answer = await self._found(question)
            except Exception:  # noqa: BLE001  (the database is away: the run waits for it)
                _log.exception("what a host asked for could not be read")
                await asyncio.sleep(_PAUSE)
            else:
                break
        for piece in _pieces(answer):
            send(HostMessage(HostMessageKind.REPLY, 0, message.run, piece))

    async def _found(self, question: Mapping[str, Sequence[str]]) -> bytes:
        if self._source is None:
            return b"{}\n"
        if "parts" in question:
            parts = await self._source.parts(question["parts"])
            return encode({digest: list(each) for digest, each in parts.items()}).encode()
        contents = await self._source.contents(question["contents"])
        sizes = encode({digest: len(content) for digest, content in contents.items()})
        return b"".join([sizes.encode(), b"\n", *contents.values()])


def _pieces(answer: bytes) -> Iterator[bytes]:
    """Yield an answer in pieces; before each is whether more follow."""
    for begin in range(0, max(1, len(answer)), _PIECE):
        is_last = begin + _PIECE >= len(answer)
        yield (b"\0" if is_last else b"\1") + answer[begin : begin + _PIECE]
