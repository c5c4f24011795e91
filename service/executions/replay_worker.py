"""Replays of what executions moved, in 3-D."""

from contextlib import ExitStack
from typing import TYPE_CHECKING

from planning.world.replay.replay_writer import ShownMotion, replay_motions_html
from service.executions.tasks import REPLAY_MOTIONS, ReplayWork
from service.jobs.context import TaskContext
from service.plans.tasks import Page
from service.scenes.world_cache import borrow_world

if TYPE_CHECKING:
    from planning import World


@REPLAY_MOTIONS.runs
def replay_motions(work: ReplayWork, _: TaskContext) -> Page:
    """Make the page that replays motions in 3-D, one after the other.

    Raises:
        InputError: A scene does not load any more.
    """
    worlds: dict[str, World] = {}
    shown: list[ShownMotion] = []
    with ExitStack() as borrowed:
        for motion in work.motions:
            scene = motion.scene.model_dump_json()  # where other robots and groups were, too
            if scene not in worlds:
                worlds[scene] = borrowed.enter_context(borrow_world(motion))
            world, trajectory = worlds[scene], motion.trajectory.to_domain()
            group = world.group(motion.group)
            shown.append(ShownMotion(motion.title, world, group, trajectory, motion.until))
        return Page(html=replay_motions_html(shown))
