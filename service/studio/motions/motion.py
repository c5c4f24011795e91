"""Motion: a planned motion with what is proven and known of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from service.studio.api import Api, ShownGroup
from service.studio.motions.keyframes import Keyframes, load_keyframes
from service.studio.motions.series import Series


@dataclass(frozen=True)
class Motion(Keyframes):
    """A motion in a scene, as it is looked at.

    Attributes:
        certificate: As the API has it.
        series: Its rates, efforts and limits.
        job: The plan, with its request and its result.
    """

    certificate: Mapping[str, Any]
    series: Series
    job: Mapping[str, Any] = field(default_factory=dict[str, Any])


def load_motion(
    api: Api, scene: str, group: ShownGroup, job: Mapping[str, Any], bodies: Sequence[str]
) -> Motion:
    """Return the motion of a plan that succeeded.

    Args:
        api: Says where bodies are.
        scene: That it moves in.
        group: That moves.
        job: The plan, with its result.
        bodies: That move.
    """
    frames = load_keyframes(api, scene, group, job, bodies)
    return Motion(
        **vars(frames),
        certificate=job["result"]["certificate"],
        series=api.series(job["id"]),
        job=job,
    )
