"""JSON Schemas of scene and robot files, as editors use them while a file is written.

`python -m service.cli.commands.file_schemas` writes those that the bundled files name.
"""

import json
from pathlib import Path
from typing import Any

from planning import bundled_folder
from planning.world.documents.scene_document import SceneDocument
from planning.world.models.robot_card import RobotCard

_DIALECT = "https://json-schema.org/draft/2020-12/schema"


def scene_schema() -> dict[str, Any]:
    """Return the schema of `*.scene.yaml`."""
    return {"$schema": _DIALECT, **SceneDocument.model_json_schema()}


def robot_schema() -> dict[str, Any]:
    """Return the schema of `robot.yaml`."""
    return {"$schema": _DIALECT, **RobotCard.model_json_schema()}


def files() -> dict[Path, str]:
    """Return the text of each file beside what is bundled."""
    schemas = {
        bundled_folder("scenes") / "scene.schema.json": scene_schema(),
        bundled_folder("models") / "robot.schema.json": robot_schema(),
    }
    return {file: json.dumps(schema, indent=1) + "\n" for file, schema in schemas.items()}


def main() -> None:
    """Write the files."""
    for file, text in files().items():
        file.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
