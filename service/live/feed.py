"""LiveFeeds: what is told of the live states of scenes that are watched.

Of each scene that is watched there is one feed, however many watch it: it reads the records once,
and follows the executions that move something. Who watches takes the newest state when it is ready
for it. So a slow one holds nothing up, and nothing is kept for it.
"""

import asyncio
import logging
from collections.abc import AsyncGenerator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from service.errors import UnknownResource
from service.executions.measured import STATUS, open_motions, told
from service.jobs.errors import UnknownJob
from service.jobs.service import JobService
from service.jobs.store.sql.database import is_of_database
from service.live.models import HeldObject
from service.live.resource import held_objects, live_state
from service.scenes.live import Motion, RobotState, moved_by
from service.scenes.store.records import SceneRecord
from service.scenes.store.scene_store import SceneStore

# Before a database that is away is asked again [s].
_PAUSE = 1.0
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)
_MICROSECOND = timedelta(microseconds=1)
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Told:
    """A live state that was told.

    Attributes:
        number: Grows with each of a scene: the instant of its newest part [us since 1970], unless
            clocks of several servers differ.
        text: The state as JSON.
    """

    number: int
    text: str


@dataclass(frozen=True)
class Watch:
    """How a scene is watched.

    Attributes:
        rate: States that are told each second, at most.
        seen: Number of the state that is known already; None for none.
        most: How many states are told; None for no end.
    """

    rate: float
    seen: int | None = None
    most: int | None = None


class LiveFeeds:
    """The feeds of the scenes that are watched; belongs to one event loop."""

    def __init__(self, scenes: SceneStore, jobs: JobService) -> None:
        """Read the records of scenes and of executions."""
        self._scenes = scenes
        self._jobs = jobs
        self._feeds: dict[str, _Feed] = {}

    @property
    def num_feeds(self) -> int:
        """How many scenes are watched."""
        return len(self._feeds)

    async def follow(self, scene: str, watch: Watch) -> AsyncGenerator[Told]:
        """Yield the newest state of a scene whenever there is a newer one, and it was taken.

        It ends with the scene, or with the server.

        Args:
            scene: Its id; of one that is not there nothing is told.
            watch: How it is watched.
        """
        feed = self._feeds.get(scene)
        if feed is None:
            feed = self._feeds[scene] = _Feed(scene, self._scenes, self._jobs)
        feed.num_watching += 1
        seen, left = watch.seen, watch.most
        clock = asyncio.get_running_loop().time
        try:
            while left != 0:
                changed, newest = feed.changed, feed.newest
                if newest is not None and newest.number != seen:
                    due = clock() + 1.0 / watch.rate
                    yield newest
                    seen, left = newest.number, None if left is None else left - 1
                    await asyncio.sleep(max(0.0, due - clock()) if left != 0 else 0.0)
                elif feed.is_over:
                    return
                else:
                    await changed.wait()
        finally:
            feed.num_watching -= 1
            if feed.num_watching == 0:
                feed.close()
                if self._feeds.get(scene) is feed:
                    del self._feeds[scene]


class _Feed:
    """The newest live state of a scene, and a signal of the next.

    Attributes:
        newest: It; None before it was read.
        changed: Set once there is another one, or none any more.
        is_over: Whether there will be no other.
        num_watching: How many watch it.
    """

    def __init__(self, scene: str, scenes: SceneStore, jobs: JobService) -> None:
        self.newest: Told | None = None
        self.changed = asyncio.Event()
        self.is_over = False
        self.num_watching = 0
        self._scene = scene
        self._scenes = scenes
        self._jobs = jobs
        self._held: tuple[int, list[HeldObject]] | None = None
        self._task = asyncio.get_running_loop().create_task(self._run())

    def close(self) -> None:
        """Tell nothing more."""
        self._task.cancel()

    async def _run(self) -> None:
        try:
            with self._jobs.watch(self._scene) as next_change:
                while not self._jobs.is_stopping:
                    # Taken before reading: what changes meanwhile wakes us at once.
                    changed = next_change()
                    await self._tell_until(changed)
        except UnknownResource:
            pass  # it is deleted
        except Exception:  # noqa: BLE001  (who watches is told that it is over)
            _log.exception("the live state of %s is not told any more", self._scene)
        finally:
            self.is_over = True
            self._wake()

    async def _tell_until(self, changed: asyncio.Event) -> None:
        """Tell the state, and what executions measure, until the records have to be read again.

        Raises:
            UnknownResource: The scene is gone.
        """
        try:
            motions = await open_motions(self._scene, jobs=self._jobs)
            record = await self._scenes.at(self._scene, motions)
        except Exception as fault:
            if not is_of_database(fault):
                raise
            _log.warning("the live state of %s cannot be read: %s", self._scene, fault)
            await asyncio.sleep(_PAUSE)
            return
        states, held = dict(record.live), self._held_in(record)
        self._tell(record, states, held)
        work = [self._follow(motion, record, states, held) for motion in motions]
        tasks = [asyncio.ensure_future(each) for each in (changed.wait(), *work)]
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def _follow(
        self,
        motion: Motion,
        record: SceneRecord,
        states: dict[str, RobotState],
        held: list[HeldObject],
    ) -> None:
        """Tell what an execution measures until it ends; what ends it is in the records by then."""
        with suppress(UnknownJob):  # it has ended and was deleted
            async for event in self._jobs.events_of(motion.execution, motion.number):
                if event.type == STATUS:
                    now = told(motion, event)
                    for robot in motion.robots:
                        states[robot] = moved_by(now, states[robot])
                    self._tell(record, states, held)

    def _held_in(self, record: SceneRecord) -> list[HeldObject]:
        """Return what robots hold in a revision, whose document is read once."""
        if self._held is None or self._held[0] != record.revision:
            self._held = record.revision, held_objects(record)
        return self._held[1]

    def _tell(
        self, record: SceneRecord, states: Mapping[str, RobotState], held: list[HeldObject]
    ) -> None:
        text = live_state(record, states, held).model_dump_json(ensure_ascii=True)
        before = self.newest
        if before is not None and before.text == text:
            return
        newest = max([record.created_at, *(state.updated_at for state in states.values())])
        number = (newest - _EPOCH) // _MICROSECOND
        if before is not None:
            number = max(number, before.number + 1)
        self.newest = Told(number, text)
        self._wake()

    def _wake(self) -> None:
        self.changed.set()
        self.changed = asyncio.Event()
