"""wayproof schema: JSON Schemas of the files that people write."""

from enum import StrEnum
from typing import Annotated

import typer

from service.cli.commands.file_schemas import robot_schema, scene_schema
from service.cli.output import print_json


class Kind(StrEnum):
    """What people write."""

    SCENE = "scene"
    ROBOT = "robot"


def schema(kind: Annotated[Kind, typer.Argument(help="Of which files.")]) -> None:
    """Print the JSON Schema of scene or robot files, by which editors complete and underline.

    A file names it in its first line: `# yaml-language-server: $schema=scene.schema.json`.
    """
    print_json(scene_schema() if kind is Kind.SCENE else robot_schema())
