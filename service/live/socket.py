"""WebSocket /v1/scenes/{id}/state/ws: the events of a live state, each as a text of JSON."""

from contextlib import aclosing, suppress
from typing import Annotated

from anyio import CancelScope, create_task_group
from fastapi import APIRouter, Query, WebSocket, WebSocketDisconnect

from service.api.error_responses import respond
from service.api.params import SceneId
from service.errors import UnknownResource
from service.live.dependencies import MAX_RATE, FeedsDep
from service.live.feed import LiveFeeds, Watch
from service.scenes.dependencies import ScenesDep

router = APIRouter(prefix="/v1/scenes/{scene}/state")

# Codes of RFC 6455: the scene is gone, or the server ends.
_GOING_AWAY = 1001

type Rate = Annotated[float, Query(gt=0, le=MAX_RATE)]
type Seen = Annotated[int | None, Query(ge=0)]


@router.websocket("/ws")
async def send_scene_state(
    socket: WebSocket,
    scene: SceneId,
    scenes: ScenesDep,
    feeds: FeedsDep,
    rate: Rate = 20.0,
    after: Seen = None,
) -> None:
    """Send the live state: now, unless it is the one `after`, and whenever it changes.

    What the client sends is not heeded. A scene that does not exist is answered 404, before the
    connection is one.
    """
    try:
        record = await scenes.get(scene)
    except UnknownResource as fault:
        await socket.send_denial_response(respond(fault))
        return
    await socket.accept()
    has_ended = False
    async with create_task_group() as both:
        both.start_soon(_until_left, socket, both.cancel_scope)
        await _send(socket, feeds, record.id, Watch(rate, after))
        has_ended = True
        both.cancel_scope.cancel()
    if has_ended:
        with suppress(RuntimeError, WebSocketDisconnect):  # the client was quicker
            await socket.close(_GOING_AWAY)


async def _send(socket: WebSocket, feeds: LiveFeeds, scene: str, watch: Watch) -> None:
    """Send what is told; each text is taken by the connection before the next is looked for."""
    with suppress(WebSocketDisconnect):
        async with aclosing(feeds.follow(scene, watch)) as states:
            async for told in states:
                await socket.send_text(
                    f'{{"id":"{told.number}","event":"state","data":{told.text}}}'
                )


async def _until_left(socket: WebSocket, scope: CancelScope) -> None:
    """End what is sent once the client has left."""
    while (await socket.receive())["type"] != "websocket.disconnect":
        pass
    scope.cancel()
