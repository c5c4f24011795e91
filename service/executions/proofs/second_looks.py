"""SecondLooks: verdicts on motions that could not be decided in time are sought again.

A machine that is busy may take longer than a verdict may. The robot rests meanwhile, and would do
so until the next edit, though nothing is in its way.
"""

import asyncio
import logging

from service.errors import UnknownResource
from service.scenes.store.scene_store import SceneStore

# Between two looks at what is undecided [s].
_PAUSE = 2.0
_log = logging.getLogger(__name__)


class SecondLooks:
    """Has scenes judged again; belongs to one event loop."""

    def __init__(self, scenes: SceneStore) -> None:
        """Have nothing to look at yet."""
        self._scenes = scenes
        self._undecided: dict[str, int] = {}

    def ask(self, scene: str, revision: int) -> None:
        """Have the motions in a revision of a scene judged again, unless it is edited before."""
        self._undecided[scene] = revision

    async def run(self) -> None:
        """Look again at what is undecided, until canceled."""
        while True:
            await asyncio.sleep(_PAUSE)
            undecided, self._undecided = self._undecided, {}
            for scene, revision in undecided.items():
                await self._look(scene, revision)

    async def _look(self, scene: str, revision: int) -> None:
        try:
            record = await self._scenes.fresh(scene)
            if record.revision == revision:
                await self._scenes.verdicts(record)
        except UnknownResource:
            pass  # it is deleted
        except Exception:  # noqa: BLE001  (the robot rests; it is looked at once more)
            _log.exception("the motions in %s were not judged again", scene)
            self._undecided.setdefault(scene, revision)
