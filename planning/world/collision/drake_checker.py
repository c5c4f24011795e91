"""Drake's collision checker of a model, and margins as its padding."""

from itertools import combinations
from typing import Any

import numpy as np
from pydrake.common import Parallelism
from pydrake.planning import CollisionCheckerParams, SceneGraphCollisionChecker

from planning.world.collision.half_spaces import exclude_half_spaces
from planning.world.collision.margins import PairMargins
from planning.world.drake_model import DrakeModel


def make_collision_checker(model: DrakeModel) -> SceneGraphCollisionChecker:
    """Return Drake's checker of a model, without margins.

    Making one takes longer than many plans; copying it does not.
    """
    plant = model.plant
    moving_bodies = [plant.get_joint(index).child_body() for index in model.joint_indices.values()]
    attached_bodies = [plant.get_body(model.bodies[name]) for name in model.owners]
    robots = sorted({body.model_instance() for body in [*moving_bodies, *attached_bodies]}, key=int)
    return distance_checker(model, robots)


def distance_checker(model: DrakeModel, robots: list[Any]) -> SceneGraphCollisionChecker:
    """Return Drake's checker of model instances; pairs with half spaces are measured elsewhere."""
    checker = SceneGraphCollisionChecker(
        CollisionCheckerParams(
            model=model.diagram,
            robot_model_instances=robots,
            edge_step_size=0.05,
            implicit_context_parallelism=Parallelism(1),
        )
    )

    def exclude(diagram: Any, contexts: Any) -> None:
        graph = diagram.scene_graph()
        exclude_half_spaces(graph, graph.GetMyMutableContextFromRoot(contexts.model_context()))

    checker.PerformOperationAgainstAllModelContexts(exclude)
    return checker


def apply_margins(checker: Any, model: DrakeModel, margins: PairMargins) -> None:
    """Set the margin of every pair of bodies as padding of Drake's checker."""
    named_bodies = [
        (int(index), name, checker.IsPartOfRobot(index)) for index, name in model.body_names.items()
    ]
    padding = np.array(checker.GetPaddingMatrix())
    for (i, a, a_moves), (j, b, b_moves) in combinations(named_bodies, 2):
        if a_moves or b_moves:
            padding[i, j] = padding[j, i] = margins.of(a, b)
    checker.SetPaddingMatrix(padding)
