"""Pages from sources: settings, files, commands, and the public names of `planning`."""

import ast
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer
from pydantic_core import PydanticUndefined

from docs.site.schema_tables import SchemaTables, cell
from service.cli.app import app
from service.settings import PREFIX, Settings

ROOT = Path(__file__).parents[2]


def source_pages() -> Iterator[tuple[str, str]]:
    """Yield path and text of each page."""
    yield "reference/settings.md", _settings()
    yield "reference/commands.md", _commands()
    yield "reference/python.md", _python()
    yield (
        "reference/scene-file.md",
        _file("Scene files", "`*.scene.yaml`", "../how-to/scenes.md", "scenes/scene.schema.json"),
    )
    yield (
        "reference/robot-file.md",
        _file(
            "Robot files", "`robot.yaml`", "../how-to/your-own-robot.md", "models/robot.schema.json"
        ),
    )


def _settings() -> str:
    rows = []
    for name, field in Settings.model_fields.items():
        default = (
            "" if field.default is PydanticUndefined else json.dumps(field.default, default=str)
        )
        default = default or "of this machine"
        rows.append(f"| `{PREFIX}{name.upper()}` | `{default}` | {field.description} |")
    return (
        "# Settings\n\nA server reads them from its environment; `wayproof config` prints them as a"
        " server that starts now would have them."
        " [Running the service](../how-to/operations.md) says when to change which.\n\n"
        "| variable | default | meaning |\n|---|---|---|\n" + "\n".join(rows) + "\n"
    )


def _file(title: str, name: str, guide: str, path: str) -> str:
    schema = json.loads((ROOT / path).read_text(encoding="utf-8"))
    models = {**schema.get("$defs", {}), "The file": schema}
    head = (
        f"# {title}\n\nEvery field of {name}; [the guide]({guide}) explains them. The schema is in"
        f" `{path}`: editors complete and underline by it.\n\n"
    )
    return head + SchemaTables(models).section("The file") + "\n"


def _commands() -> str:
    group: Any = typer.main.get_command(app)
    parts = ["# Options of the commands", "[The command line](cli.md) says what they are for."]
    for name in group.list_commands(typer.Context(group)):
        parts += _command(f"wayproof {name}", group.commands[name])
    return "\n\n".join(parts) + "\n"


def _command(name: str, command: Any) -> Iterator[str]:
    yield f"## {name}"
    yield (command.help or "").partition("\n\n")[0]
    shown = [each for each in command.params if not getattr(each, "hidden", False)]
    rows = [f"| `{_spelt(each)}` | {cell(getattr(each, 'help', '') or '')} |" for each in shown]
    if rows:
        yield "\n".join(["| option | meaning |", "|---|---|", *rows])
    for inner in sorted(getattr(command, "commands", {})):
        yield from _command(f"{name} {inner}", command.commands[inner])


def _spelt(parameter: Any) -> str:
    is_option = parameter.param_type_name == "option"
    return " ".join(parameter.opts) if is_option else (parameter.name or "").upper()


def _python() -> str:
    head = "# Python\n\nThe public names of `planning`; each is imported when it is first used."
    parts = [head]
    for module, name in _public_names():
        parts.append(_definition(ROOT / "planning" / f"{module.replace('.', '/')}.py", name))
    return "\n\n".join(parts) + "\n"


def _public_names() -> list[tuple[str, str]]:
    tree = ast.parse((ROOT / "planning" / "__init__.pyi").read_text(encoding="utf-8"))
    found = {
        (node.module or "", alias.name)
        for node in tree.body
        if isinstance(node, ast.ImportFrom) and node.level
        for alias in node.names
    }
    return sorted(found, key=lambda each: each[1].lower())


def _definition(file: Path, name: str) -> str:
    for node in ast.parse(file.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name == name:
            is_class = isinstance(node, ast.ClassDef)
            head = f"class {name}" if is_class else f"{name}({ast.unparse(node.args)})"
            docstring = ast.get_docstring(node) or ""
            return f"## {name}\n\n```text\n{head}\n\n{docstring}\n```"
    return f"## {name}\n\nA value of `{file.relative_to(ROOT)}`."
