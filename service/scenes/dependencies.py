"""The scenes that endpoints are handed."""

from typing import Annotated

from fastapi import Depends, Request

from service.scenes.store import SceneStore


async def _scenes(request: Request) -> SceneStore:
    scenes: SceneStore = request.app.state.scenes
    return scenes


type ScenesDep = Annotated[SceneStore, Depends(_scenes)]
