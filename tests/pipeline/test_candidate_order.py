"""Order of candidate motions: no refined one before a cheaper one along the path was refused."""

from pathlib import Path

import numpy as np
import pytest

import planning
from planning.domain.curves.path import JointPath
from planning.domain.report.stage_reports import RefineReport
from planning.domain.request.options import ClearanceObjective, RefineOptions, RetimeOptions
from planning.domain.request.refine_objective import RefineObjective
from planning.domain.request.stopwatch import Stopwatch
from planning.pipeline import candidate_motions
from planning.retime.blend import blend_corners
from tests.clocks import no_hurry
from tests.refine.conftest import puck_world

BOX = ([0.1, 0.1, 0.2], [0.0, -0.5, 0.0])
# Rounded by 0.1 these are the shortest, and by 0 the longest; 0.02 is refused by none of them.
CORNERS = np.array([[-0.6, -0.2], [-0.1, 0.4], [0.4, -0.1], [0.6, 0.3]])
WAYS = {
    "duration": RefineOptions(),
    "length": RefineOptions(objective=RefineObjective(path_length=1.0)),
    "sum": RefineOptions(objective=RefineObjective(1.0, 0.01, path_length=1.0)),
    "clearance": RefineOptions(clearance=ClearanceObjective(0.05, 1.0)),
}


@pytest.mark.parametrize("method", ["toppra", "ruckig"])
@pytest.mark.parametrize("options", WAYS.values(), ids=WAYS)
def test_each_refusal_leads_to_the_cheapest_of_what_is_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: RefineOptions, method: str
) -> None:
    """The refined curve lies between the second and the third one along the path by its cost."""
    world = puck_world(tmp_path, [BOX])
    path = JointPath(world.group("puck"), CORNERS)
    smoothness = 2 if method == "ruckig" else 1
    refined = blend_corners(path, 0.02, smoothness), RefineReport("trajopt", improved=True)
    monkeypatch.setattr(candidate_motions, "refine", lambda *_: refined)
    problem = planning.PlanningProblem(
        "puck", planning.JointGoal(CORNERS[-1:]), refine=options, retime=RetimeOptions(method)
    )
    deadline = no_hurry(60.0)
    found = list(
        candidate_motions.candidates(
            world,
            path,
            problem,
            world.margins(None),
            deadline,
            Stopwatch(deadline.clock),
            path_limits=(),
        )
    )
    names = [candidate.name for candidate in found]
    assert len(set(names)) == len(names)
    place = names.index("refined curve")
    assert 0 < place < len(names) - 1
    assert found[place - 1].cost <= found[place].cost <= found[place + 1].cost
