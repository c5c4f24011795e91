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
from planning.domain.scene.scene_operation import SceneOperation
from service.scenes.edit_models import (
    AddOperationWire,
    AllowOperationWire,
    AttachOperationWire,
    DetachOperationWire,
    ForbidOperationWire,
    MoveOperationWire,
    RemoveOperationWire,
    SceneOperationWire,
    SetPositionsOperationWire,
)


def operation_value(wire: SceneOperationWire) -> SceneOperation:  # noqa: C901, PLR0911  (one case each)
    """Return an operation for the domain."""
    match wire:
        case AddOperationWire():
            return AddObject(wire.object.value())
        case MoveOperationWire():
            return MoveObject(wire.object, wire.pose.value())
        case RemoveOperationWire():
            return RemoveObject(wire.object)
        case AttachOperationWire():
            touch = None if wire.touch is None else tuple(wire.touch)
            pose = None if wire.pose is None else wire.pose.value()
            return AttachObject(wire.object, wire.frame, touch, pose)
        case DetachOperationWire():
            return DetachObject(wire.object)
        case SetPositionsOperationWire():
            return _set_positions(wire)
        case AllowOperationWire():
            return AllowPair((wire.pair[0], wire.pair[1]))
        case ForbidOperationWire():
            return ForbidPair((wire.pair[0], wire.pair[1]))


def _set_positions(wire: SetPositionsOperationWire) -> SetPositions:
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
