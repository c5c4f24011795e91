"""scene_summary(): groups, frames, bodies, unchecked pairs and warnings of a loaded scene."""

from weakref import WeakKeyDictionary

from pydrake.planning import RobotDiagram

from planning.domain.scene.summary import GroupSummary, SceneSummary
from planning.world.collision.collision_pairs import collision_pairs_of
from planning.world.collision.unchecked_pairs import unchecked_pairs
from planning.world.drake_model import DrakeModel
from planning.world.files.hull_warnings import hull_warnings
from planning.world.loading.start_warnings import start_warnings
from planning.world.mechanics.grippers import gripper_of
from planning.world.world import World

type _Names = tuple[tuple[str, ...], tuple[str, ...]]

# Of each engine the names of one table of objects, with its rows: those of moved objects are these.
_sorted_names_cache: WeakKeyDictionary[RobotDiagram, tuple[dict[str, int], _Names]] = (
    WeakKeyDictionary()
)


def scene_summary(world: World) -> SceneSummary:
    """Return the summary of a loaded scene, with its warnings."""
    groups = {
        group.name: GroupSummary(
            group,
            world.limits(group),
            {name: tuple(map(float, q)) for name, q in world.configurations(group).items()},
            tuple(map(float, world.positions(group))),
            world.scene_groups.members(group) if group in world.scene_groups.spanning else (),
            gripper_of(world, group),
        )
        for group in (*world.groups, *world.scene_groups.spanning)
    }
    frames, bodies = _sorted_names(world.drake)
    return SceneSummary(
        groups=groups,
        frames=frames,
        bodies=bodies,
        num_pairs=len(collision_pairs_of(world.drake).rows),
        digest=world.digest,
        unchecked=unchecked_pairs(world.drake),
        warnings=(
            *world.drake.warnings,
            *(text for own in world.robot_groups for text in own.warnings),
            *start_warnings(world),
            *hull_warnings(world.drake),
        ),
        assumed=tuple(
            f"{own.robot}::{joint}" for own in world.robot_groups for joint in own.assumed
        ),
    )


def _sorted_names(model: DrakeModel) -> _Names:
    """Return the names of all frames and bodies; models with the same objects share them."""
    rows = model.static_objects.rows
    found = _sorted_names_cache.get(model.diagram)
    if found is None or found[0] is not rows:
        names = tuple(sorted(model.all_frames)), tuple(sorted(model.all_bodies))
        found = _sorted_names_cache[model.diagram] = rows, names
    return found[1]
