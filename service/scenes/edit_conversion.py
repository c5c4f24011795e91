"""Operations on scenes from the wire."""

from planning import (
    AddObject,
    AllowPair,
    AttachObject,
    DetachObject,
    ForbidPair,
    MoveObject,
    RemoveObject,
    SetPositions,
)
from planning.domain.scene import scene_operation as domain
from service.scenes.edit_models import (
    AddOperation,
    AllowOperation,
    AttachOperation,
    DetachOperation,
    ForbidOperation,
    MoveOperation,
    RemoveOperation,
    SceneOperation,
    SetPositionsOperation,
)


def operation_value(wire: SceneOperation) -> domain.SceneOperation:  # noqa: C901, PLR0911  (one case each)
    """Return an operation for the domain."""
    match wire:
        case AddOperation():
            return AddObject(wire.object.value())
        case MoveOperation():
            return MoveObject(wire.object, wire.pose.value())
        case RemoveOperation():
            return RemoveObject(wire.object)
        case AttachOperation():
            touch = None if wire.touch is None else tuple(wire.touch)
            pose = None if wire.pose is None else wire.pose.value()
            return AttachObject(wire.object, wire.frame, touch, pose)
        case DetachOperation():
            return DetachObject(wire.object)
        case SetPositionsOperation():
            return _set_positions(wire)
        case AllowOperation():
            return AllowPair((wire.pair[0], wire.pair[1]))
        case ForbidOperation():
            return ForbidPair((wire.pair[0], wire.pair[1]))


def _set_positions(wire: SetPositionsOperation) -> SetPositions:
    match wire.positions:
        case str() as name:
            return SetPositions(wire.robot, name)
        case list() as values:
            return SetPositions(wire.robot, tuple(values))
        case dict() as by_joint:
            placed: dict[str, float | tuple[float, ...]] = {
                k: tuple(v) if isinstance(v, list) else v for k, v in by_joint.items()
            }
            return SetPositions(wire.robot, placed)
