"""wayproof: serve, studio, plan, demo, config, keys, backup, restore."""

import importlib
from collections.abc import Iterator, Mapping, MutableMapping
from typing import Any, cast, override

import typer
from typer.core import TyperGroup

_NAMES = ("serve", "studio", "plan", "demo", "config", "keys", "backup", "restore")
_OPTIONS = {"add_completion": False, "pretty_exceptions_enable": False}


class _Commands(Mapping[str, Any]):
    """Commands by name, imported when they are asked for: what `demo` needs holds up `serve`."""

    @override
    def __getitem__(self, name: str) -> Any:
        if name not in _NAMES:
            raise KeyError(name)
        module = importlib.import_module(f"service.cli.{name}")
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
    no_args_is_help=True,
    **cast("Any", _OPTIONS),
)


@app.callback()
def _wayproof() -> None:
    pass
