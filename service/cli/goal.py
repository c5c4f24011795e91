"""What `--to` means: a frame to bring the tool to, or a configuration by name."""

from typing import Any

import typer

from planning.errors import UnknownName
from service.cli.exit_codes import ExitCode
from service.cli.output import error_console
from wayproof_client.models import Group, Scene


def configuration_of(group: Group, name: str | None) -> list[float]:
    """Return a configuration by its name, or the current one.

    Raises:
        typer.Exit: There is none of that name.
    """
    return group.positions if name is None else start_of(group, name) or []


def group_of(scene: Scene, name: str | None) -> Group:
    """Return a group of the scene, by default its first.

    Raises:
        typer.Exit: There is none of that name.
    """
    for group in scene.groups:
        if name in {None, group.name, *group.aliases}:
            return group
    names = [group.name for group in scene.groups]
    raise _refusal(UnknownName.among("group", str(name), names).detail)


def goal_of(scene: Scene, group: Group, target: str) -> dict[str, Any]:
    """Return the goal that a name means: a frame, else a configuration.

    Raises:
        typer.Exit: It is neither.
    """
    if target in scene.frames:
        return {"type": "pose", "poses": [{"position": [0, 0, 0], "frame": target}]}
    if target in group.configurations:
        return {"type": "configuration", "name": target}
    unknown = UnknownName.among("name", target, [*scene.frames, *group.configurations])
    nearest = "".join(f"did you mean {near!r}? " for near in unknown.evidence["nearest"][:1])
    raise _refusal(
        f"{target!r} is neither a frame nor a configuration; {nearest}"
        f"frames: {', '.join(scene.frames)}; configurations: {', '.join(group.configurations)}"
    )


def start_of(group: Group, name: str | None) -> list[float] | None:
    """Return the configuration to start from, None for the scene's current state.

    Raises:
        typer.Exit: There is none of that name.
    """
    if name is None:
        return None
    if name not in group.configurations:
        raise _refusal(UnknownName.among("configuration", name, group.configurations).detail)
    return group.configurations[name]


def _refusal(message: str) -> typer.Exit:
    """Say what is wrong, and return what ends the command."""
    error_console.print(message, markup=False)
    return typer.Exit(ExitCode.USAGE)
