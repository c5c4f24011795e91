"""The studio's process: it shows nothing without the token, and comes back when it has died."""

import asyncio
import struct

import msgspec
import pytest
import zstandard
from websockets.asyncio.client import connect

from planning import bundled_folder
from service.studio.front import HOST_HEADER, TOKEN_HEADER
from service.studio.process import StudioProcess
from tests.profiles import only_campaign

_VISER = "viser-v1.1.1"
# What a page says first; viser waits for it.
_CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (1.0, 1.0, 1.0),
    "fov": 1.0,
    "near": 0.01,
    "far": 100.0,
    "image_height": 400,
    "image_width": 400,
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}


def text_of(message):
    """What viser packed: the length of the text, of what was made of it, and that."""
    _, packed = struct.unpack("<QQ", message[:16])
    return zstandard.ZstdDecompressor().decompress(message[16 : 16 + packed])


async def shown(port, token, until, seconds=60.0):
    """What a browser is told, up to a text or an end of patience."""
    told = b""
    headers = {TOKEN_HEADER: token, HOST_HEADER: ""}
    async with connect(
        f"ws://127.0.0.1:{port}",
        subprotocols=[_VISER],
        additional_headers=headers,
        max_size=None,
        proxy=None,
    ) as browser:
        await browser.send(msgspec.msgpack.encode(_CAMERA))
        try:
            async with asyncio.timeout(seconds):
                while until not in told:
                    told += text_of(await browser.recv())
        except TimeoutError:
            pass
    return told


async def process_of(real_server):
    return StudioProcess(real_server.url, bundled_folder("scenes"))


@only_campaign("starts the process twice: 12 s")
@pytest.mark.slow
def test_it_shows_scenes_to_who_has_the_token_and_comes_back_when_it_died(real_server):
    async def story():
        studio = await process_of(real_server)
        port, token = await studio.upstream()
        try:
            told = await shown(port, token, b"ways to reach it")
            assert b"ur5e_pickup" in told
            assert b"maze_2d" in told
            nothing = await shown(port, "another", b"ur5e_pickup", seconds=2.0)
            assert b"ur5e_pickup" not in nothing
            assert b"Plan" not in nothing

            studio._process.kill()
            await studio._process.wait()
            again = await studio.upstream()
            assert again[1] != token
            assert b"Plan" in await shown(*again, b"Plan")

            studio._process.stdin.close()  # as when the server is gone
            assert await asyncio.wait_for(studio._process.wait(), 60) == 0
        finally:
            if studio._process.returncode is None:
                studio._process.kill()
                await studio._process.wait()

    asyncio.run(story())
