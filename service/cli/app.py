"""wayproof: the commands, each imported when it is asked for."""

import importlib
from collections.abc import Iterator, Mapping, MutableMapping
from typing import Annotated, Any, cast, override

import typer
from typer.core import TyperGroup

from service.cli.exit_codes import EPILOG
from service.versions import versions

# In the order of `--help`; modules beside this one, or among the commands.
_BESIDE = ("serve", "studio", "demo", "plan")
_NAMES = (
    *_BESIDE,
    *("execute", "check", "ik", "scenes", "models", "bench", "schema", "doctor"),
    *("config", "keys", "backup", "restore", "replay"),
)
# In Markdown, brackets stay what they are: `[s]` would be a colour otherwise.
_OPTIONS = {
    "add_completion": False,
    "pretty_exceptions_enable": False,
    "rich_markup_mode": "markdown",
}


class _Commands(Mapping[str, Any]):
    """Commands by name, imported when they are asked for: what `demo` needs holds up `serve`."""

    @override
    def __getitem__(self, name: str) -> Any:
        if name not in _NAMES:
            raise KeyError(name)
        package = "service.cli" if name in _BESIDE else "service.cli.commands"
        module = importlib.import_module(f"{package}.{name}")
        if hasattr(module, "COMMANDS"):  # of its own
            return typer.main.get_command(module.COMMANDS)
        alone = typer.Typer(**cast("Any", _OPTIONS))
        alone.command(name, epilog=getattr(module, "EPILOG", None))(getattr(module, name))
        return typer.main.get_command(alone)

    @override
    def __iter__(self) -> Iterator[str]:
        return iter(_NAMES)

    @override
    def __len__(self) -> int:
        return len(_NAMES)


class _Wayproof(TyperGroup):
    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.commands = cast("MutableMapping[str, Any]", _Commands())


app = typer.Typer(
    name="wayproof",
    cls=_Wayproof,
    help="Plans robot motion and proves it.",
    epilog=EPILOG,
    no_args_is_help=True,
    **cast("Any", _OPTIONS | {"add_completion": True}),
)


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"wayproof {versions()['wayproof']}")
        raise typer.Exit


@app.callback()
def _wayproof(
    *,
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_show_version, is_eager=True, help="Print the version, and end."
        ),
    ] = False,
) -> None:
    pass
