"""Pictures of a motion for its report: the start, the narrowest place, the goal."""

from base64 import b64encode

import numpy as np

from planning.world.replay.pictures.motion_pictures import Instant, motion_pictures
from service.jobs.context import TaskContext
from service.plans.tasks import PICTURES, MotionPictures, PictureWork
from service.scenes.world_cache import borrow_world

# Share of the duration within which the narrowest place is that of the start, or of the goal.
_SAME = 0.01
_NO_POINTS = np.empty((0, 3))


@PICTURES.runs
def draw_motion(work: PictureWork, _: TaskContext) -> MotionPictures:
    """Draw a motion at three instants.

    Raises:
        InputError: The scene does not load any more.
    """
    trajectory = work.trajectory.to_domain()
    shown = shown_instants(work, trajectory.duration)
    with borrow_world(work) as world:
        files = motion_pictures(
            world, world.group(work.group), trajectory, [instant for _, instant in shown]
        )
    return MotionPictures(
        captions=[caption for caption, _ in shown],
        base64=[b64encode(content).decode() for content in files],
    )


def shown_instants(work: PictureWork, duration: float) -> list[tuple[str, Instant]]:
    """Return the start, where it is narrowest or else midway, and the goal, each in words.

    Args:
        work: The motion.
        duration: Of it [s].
    """
    nearest = work.nearest_at
    names = " and ".join(name.rpartition("::")[2] for name in work.pair)
    found: list[tuple[str, Instant]] = []
    for place, time in (("start", 0.0), ("midway", duration / 2), ("goal", duration)):
        is_inner = nearest is not None and _SAME < nearest / duration < 1 - _SAME
        if place == "midway" and nearest is not None and is_inner:
            found.append((f"Narrowest, at {nearest:.2f} s: {names}", _marked(work, nearest)))
        elif nearest is not None and not is_inner and abs(time - nearest) <= _SAME * duration:
            caption = f"The {place}, {time:.2f} s, and narrowest: {names}"
            found.append((caption, _marked(work, nearest)))
        else:
            found.append((f"{place.capitalize()}, {time:.2f} s", Instant(time, (), _NO_POINTS)))
    return found


def _marked(work: PictureWork, time: float) -> Instant:
    points = np.array(work.points, dtype=float).reshape(-1, 3)
    return Instant(time, tuple(work.pair), points)
