"""What endpoints about live states are handed."""

from typing import Annotated

from fastapi import Depends
from fastapi.requests import HTTPConnection

from service.live.feed import LiveFeeds

# States per second: an execution tells its own twenty times a second.
MAX_RATE = 100.0


async def _feeds(connection: HTTPConnection) -> LiveFeeds:
    feeds: LiveFeeds = connection.app.state.feeds
    return feeds


type FeedsDep = Annotated[LiveFeeds, Depends(_feeds)]
