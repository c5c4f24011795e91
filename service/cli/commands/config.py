"""wayproof config: print every setting as a server that starts now would have it."""

import json
import os
import re
from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass
from typing import Annotated, Any, Literal

import typer

from service.cli.serve import settings_of
from service.cli.variables import sentence_of, unknown_variables, variable_of
from service.settings import CONFIG_FILE, Settings, read_config_file
from service.telemetry.masking import masked

EPILOG = (
    "Ends with code 2 if a variable is wrong: its value, or its name. "
    f"{CONFIG_FILE} names a TOML file of settings; the environment wins over it."
)
# In descriptions: `[s]`.
_UNIT = re.compile(r" \[([a-z]+)\]")


@dataclass(frozen=True)
class Setting:
    """A setting as it is in force.

    Attributes:
        name: In files.
        variable: In the environment.
        value: JSON-compatible, without secrets.
        source: Where it comes from.
        unit: Of the value; empty if it has none.
        description: What it is.
    """

    name: str
    variable: str
    value: Any
    source: Literal["environment", "file", "default"]
    unit: str
    description: str


def config(*, as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False) -> None:
    """Print every setting: its value, where that comes from, its unit, and what it is."""
    settings = settings_of({})
    shown = settings_in_force(settings, os.environ)
    unknown = unknown_variables(os.environ)
    if as_json:
        found = {"settings": [asdict(setting) for setting in shown], "unknown": unknown}
        typer.echo(json.dumps(found, indent=2))
    else:
        for setting in shown:
            typer.echo(_as_text(setting))
    for variable, nearest in unknown.items():
        typer.echo(sentence_of(variable, nearest), err=True)
    if unknown:
        raise typer.Exit(2)


def settings_in_force(settings: Settings, environment: Mapping[str, str]) -> list[Setting]:
    """Return every setting, by the values of `settings`, which were read from an environment."""
    values = settings.model_dump(mode="json")
    named = {name.upper() for name in environment}
    in_file = read_config_file(environment)
    shown: list[Setting] = []
    for name, field in Settings.model_fields.items():
        variable, description = variable_of(name), field.description or ""
        unit = _UNIT.search(description)
        shown.append(
            Setting(
                name=name,
                variable=variable,
                value=_without_secrets(values[name]),
                source=_source_of(name, variable, named, in_file),
                unit=unit[1] if unit else "",
                description=_UNIT.sub("", description),
            )
        )
    return shown


def _source_of(
    name: str, variable: str, named: Collection[str], in_file: Collection[str]
) -> Literal["environment", "file", "default"]:
    if variable in named:
        return "environment"
    return "file" if name in in_file else "default"


def _without_secrets(value: Any) -> Any:
    if isinstance(value, str):
        return masked(value)
    return [_without_secrets(item) for item in value] if isinstance(value, list) else value


def _as_text(setting: Setting) -> str:
    value = setting.value if isinstance(setting.value, str) else json.dumps(setting.value)
    unit = f" {setting.unit}" if setting.unit else ""
    return f"{setting.variable} = {value}{unit}  ({setting.source})\n    {setting.description}"
