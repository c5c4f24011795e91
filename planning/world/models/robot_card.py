"""RobotCard: content of the robot.yaml beside a robot's description."""

from functools import lru_cache
from pathlib import Path
from typing import Annotated

import yaml
from pydantic import AfterValidator, Field, ValidationError

from planning.errors import ModelInvalid
from planning.world.documents.strict_model import Boolean, Number, Positive, StrictModel
from planning.world.documents.yaml_text import read_yaml


def _ascending(bounds: list[float]) -> list[float]:
    if bounds[0] > bounds[1]:
        message = f"the lower bound {bounds[0]:g} is above the upper bound {bounds[1]:g}"
        raise ValueError(message)
    return bounds


def _distinct(names: list[str]) -> list[str]:
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        message = f"{twice[0]!r} is given twice"
        raise ValueError(message)
    return names


def _unscoped(name: str) -> str:
    if not name or "::" in name:
        message = (
            f"a group's name is a word without '::', which comes after the robot, got {name!r}"
        )
        raise ValueError(message)
    return name


type Range = Annotated[list[Number], Field(min_length=2, max_length=2), AfterValidator(_ascending)]
Names = Annotated[list[str], AfterValidator(_distinct)]
GroupName = Annotated[str, AfterValidator(_unscoped)]


class GroupCard(StrictModel):
    """Joint group of a robot card."""

    joints: Names = Field(min_length=1)
    tool_frames: Names = []


class RateCard(StrictModel):
    """Limits on the norm of a linear [m] or angular [rad] rate."""

    velocity: Positive
    acceleration: Positive
    jerk: Positive


class EffortCard(StrictModel):
    """Largest force [N] and torque [N m] of a planar or floating joint."""

    force: Positive
    torque: Positive


class SteeringCard(StrictModel):
    """Steering of a planar joint: smallest turning radius [m], and whether it drives backwards."""

    turning_radius: Positive
    reverse: Boolean = True


class LimitsCard(StrictModel):
    """Limits of one joint; scalar joints use the plain rates, others `linear` and `angular`."""

    velocity: Positive | None = None
    acceleration: Positive | None = None
    jerk: Positive | None = None
    effort: Positive | EffortCard | None = None
    position: dict[str, Range] = {}
    linear: RateCard | None = None
    angular: RateCard | None = None
    steering: SteeringCard | None = None


class SourceCard(StrictModel):
    """Source of a number."""

    what: str
    from_: str = Field(alias="from")


class RobotCard(StrictModel):
    """Robot data that description files cannot state: groups, limits, configurations."""

    name: str
    description: str = ""
    file: str
    base: str
    default_group: str
    groups: dict[GroupName, GroupCard] = Field(min_length=1)
    limits: dict[str, LimitsCard] = {}
    configurations: dict[str, dict[str, list[Number]]] = {}
    allowed_collisions: list[Annotated[list[str], Field(min_length=2, max_length=2)]] = []
    sources: list[SourceCard] = []


@lru_cache(maxsize=64)
def _parsed(text: str) -> RobotCard:
    """Return the card in a text, cached: parsing it takes longer than reading all other files."""
    return RobotCard.model_validate(read_yaml(text)[0])


def read_robot_card(path: Path) -> RobotCard:
    """Return the card in a file.

    Raises:
        ModelInvalid: It is no valid robot card.
    """
    try:
        card = _parsed(path.read_text(encoding="utf-8"))
    except ValidationError as fault:
        reason = "; ".join(
            f"{'.'.join(map(str, error['loc'])) or 'it'}: {error['msg']}"
            for error in fault.errors()
        )
        raise _invalid_card(path, reason) from fault
    except (yaml.YAMLError, UnicodeDecodeError) as fault:
        raise _invalid_card(path, str(fault)) from fault
    if card.default_group not in card.groups:
        message = f"default_group {card.default_group!r} is not a group: {sorted(card.groups)}"
        raise ModelInvalid(message, {"file": str(path), "reason": message})
    return card


def _invalid_card(path: Path, reason: str) -> ModelInvalid:
    message = f"{path.name} of {path.parent.name} is not a robot card: {reason}"
    return ModelInvalid(message, {"file": str(path), "reason": reason})
