"""/v1/scenes/{id}/state: where the robots of a scene are now, and a stream of it."""

from collections.abc import AsyncIterator
from typing import Annotated

from fastapi import APIRouter, Depends, Query
from fastapi.sse import EventSourceResponse, ServerSentEvent

from service.api.event_stream import EVENTS
from service.api.params import LastEventId, SceneId
from service.api.responses import problems
from service.api.routing.strict_route import StrictRoute
from service.live.dependencies import MAX_RATE, FeedsDep
from service.live.feed import Watch
from service.live.models import LiveState, StateEvent
from service.live.resource import held_objects, live_state
from service.scenes.dependencies import ScenesDep
from service.scenes.store.records import SceneRecord

router = APIRouter(route_class=StrictRoute, prefix="/v1/scenes/{scene}/state", tags=["scenes"])

_DESCRIPTION = "Server-sent events, each as the schema has it; the stream ends with the scene"

type Rate = Annotated[
    float,
    Query(
        gt=0, le=MAX_RATE, description="Largest number of states that are sent each second [1/s]"
    ),
]
type Most = Annotated[
    int | None,
    Query(
        ge=1,
        le=1_000_000,
        description="Number of states after which the stream ends; by default it goes on",
    ),
]


async def _live_record(scene: SceneId, scenes: ScenesDep) -> SceneRecord:
    return await scenes.get(scene)


type LiveRecord = Annotated[SceneRecord, Depends(_live_record)]


@router.get("", operation_id="getSceneState", responses=problems(404, 422))
async def get_scene_state(record: LiveRecord) -> LiveState:
    """Show where the robots of a scene are now, what says so, and what they hold.

    Everything that is asked of the scene without a `revision`, and without positions, begins there.
    """
    return live_state(record, record.live, held_objects(record))


@router.get(
    "/events",
    operation_id="streamSceneState",
    response_class=EventSourceResponse,
    responses={
        200: {**EVENTS, "model": StateEvent, "description": _DESCRIPTION},
        **problems(404, 422),
    },
)
async def stream_scene_state(
    record: LiveRecord,
    feeds: FeedsDep,
    rate: Rate = 20.0,
    most: Most = None,
    last_event_id: LastEventId = None,
) -> AsyncIterator[ServerSentEvent]:
    """Stream the live state: now, unless it was seen, and whenever it changes.

    Each event is the whole state. A slow reader gets the newest one, and none twice.
    `WebSocket /v1/scenes/{scene}/state/ws` sends the same, each event as a text of JSON.
    """
    # An id that is not ours is from another stream: then the state is sent.
    is_ours = last_event_id is not None and last_event_id.isdecimal()
    seen = int(last_event_id) if is_ours and last_event_id else None
    async for told in feeds.follow(record.id, Watch(rate, seen, most)):
        yield ServerSentEvent(id=str(told.number), event="state", raw_data=told.text)
