"""A duration that is asked for: met, or refused with the least that any candidate allows."""

from typing import Literal

import numpy as np
import pytest

import planning
from planning.domain.request.options import RetimeOptions
from planning.errors import RetimingFailed
from planning.world.world import World
from tests.clocks import no_hurry


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
def test_the_least_is_that_of_the_quickest(
    pickup: World, method: Literal["toppra", "ruckig"]
) -> None:
    start = pickup.positions(pickup.group("arm"))
    corner = start + np.array([0.1, 0.05, 0, 0, 0, 0])
    path = [start, corner, corner + np.array([0.1, -0.05, 0, 0, 0, 0])]

    def duration(asked: float | None) -> float:
        options = RetimeOptions(method=method, duration=asked)
        deadline = no_hurry(30)
        found = planning.retime_path(pickup, "arm", path, deadline=deadline, options=options)
        return found.trajectory.duration

    quickest = duration(None)
    assert duration(1.01 * quickest) == pytest.approx(1.01 * quickest)
    with pytest.raises(RetimingFailed, match=r"requested duration of 0\.05 s") as refused:
        duration(0.05)
    assert refused.value.evidence["least"] == pytest.approx(quickest)
    assert f"minimum of {quickest:.4g} s" in refused.value.detail
