"""Sets of measure zero are searched by sampling and by projection in turn, limited by states."""

from typing import Any

import numpy as np
import pytest

from planning.domain.request.options import SearchOptions
from planning.errors import NoPathFound
from planning.pipeline.constrained_search import _alternate_sampling_and_projection  # pyright: ignore[reportPrivateUsage]
from planning.search.request import SearchResult, SearchTask
from tests.pipeline.test_constraints import (
    DOWN,
    TOOL,
    OrientationCone,
    RefineOptions,
    beside_the_pillar,
    dense,
    hand_at,
    pillar,
    solve,
)


class Never:
    """A residual that nobody asks."""

    size = 1

    def residual(self, q: np.ndarray) -> np.ndarray:
        raise AssertionError(q)

    jacobian = residual


class Turns:
    """Stands for a search that gives up so many times."""

    def __init__(self, *ends: dict[str, Any]) -> None:
        self.ends = list(ends)
        self.asked: list[tuple[bool, float]] = []

    def __call__(self, task: SearchTask) -> SearchResult:
        self.asked.append((task.residual is not None, task.max_checked_states))
        raise NoPathFound("none", self.ends.pop(0))


GAVE_UP: dict[str, Any] = {"num_given_up": 1}
TASK = SearchTask(np.zeros(2), np.ones((1, 2)), SearchOptions(), 0.05, 0.0, 0)


def test_both_get_more_states_in_every_round() -> None:
    turns = Turns(*[GAVE_UP] * 3, {"reason": "start"})
    with pytest.raises(NoPathFound):
        _alternate_sampling_and_projection(turns, TASK, Never())
    kinds, states = zip(*turns.asked, strict=True)
    assert kinds == (False, True, False, True)
    assert states[2:] == (4 * states[0], 4 * states[1])


@pytest.mark.parametrize(
    ("ends", "tried"),
    [([{}, {}], 2), ([GAVE_UP, {}, {}, {}], 4), ([{"reason": "goals"}], 1)],
)
def test_it_ends_when_neither_gave_up_or_there_is_nothing_to_look_for(
    ends: list[dict[str, Any]], tried: int
) -> None:
    turns = Turns(*ends)
    with pytest.raises(NoPathFound):
        _alternate_sampling_and_projection(turns, TASK, Never())
    assert len(turns.asked) == tried


def test_a_thin_cone_is_kept_with_weights_too() -> None:
    world = pillar()
    found = solve(
        world,
        "panda",
        hand_at(0.4, 0.4, 0.6),
        OrientationCone(TOOL, np.array([0.0, 0.0, 1.0]), DOWN, tolerance=0.2),
        start=beside_the_pillar(),
        seed=1,
        refine=RefineOptions("none"),
        search=SearchOptions(weights={"panda::panda_joint1": 2.0}),
    )
    poses = world.frame_poses(TOOL, world.embed(world.group("panda"), dense(found)))
    angles = np.arccos(np.clip(poses[:, :3, 2] @ DOWN, -1.0, 1.0))
    assert angles.max() <= 0.2 + 2e-6
