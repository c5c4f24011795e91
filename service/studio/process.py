"""StudioProcess: the process that draws, started for the first browser and again if it has died."""

import asyncio
import json
import os
import secrets
import sys
from pathlib import Path

from service.studio.front import KEY_VARIABLE, TOKEN_VARIABLE

_START_TIMEOUT = 60.0


class StudioProcess:
    """A process of the studio; it dies with this one, which holds its stdin."""

    def __init__(self, server: str, scenes: Path, key: str | None = None) -> None:
        """Start nothing yet.

        Args:
            server: URL of the server that it asks.
            scenes: Folder of the scenes that it offers.
            key: API key that it asks with, if browsers need not give one.
        """
        self._server, self._scenes, self._key = server, scenes, key
        self._lock = asyncio.Lock()
        self._process: asyncio.subprocess.Process | None = None
        self._port = 0
        self._token = ""

    async def upstream(self) -> tuple[int, str]:
        """Return its port and the token that it wants, once it runs.

        Raises:
            OSError: It does not start.
        """
        async with self._lock:
            if self._process is None or self._process.returncode is not None:
                await self._start()
        return self._port, self._token

    async def _start(self) -> None:
        self._token = secrets.token_urlsafe(32)
        given = {TOKEN_VARIABLE: self._token}
        if self._key is not None:
            given[KEY_VARIABLE] = self._key
        command = [sys.executable, "-m", "service.studio", "--server", self._server]
        self._process = await asyncio.create_subprocess_exec(
            *command,
            "--scenes",
            str(self._scenes),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            env={**os.environ, **given},
        )
        try:
            async with asyncio.timeout(_START_TIMEOUT):
                line = await self._first_line(self._process)
            self._port = int(json.loads(line)["port"])
        except (TimeoutError, ValueError) as fault:
            self._process.kill()
            message = "the studio does not start"
            raise OSError(message) from fault

    async def _first_line(self, process: asyncio.subprocess.Process) -> bytes:
        if process.stdout is None:
            return b""
        return await process.stdout.readline()
