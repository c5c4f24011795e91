"""`python -m service.compile`: import all that servers and workers import, once.

Python compiles what it imports and keeps that (PEP 3147), where it may write beside the modules:
without it the first start takes three times as long. Installers may leave it to the first import.
"""

import importlib

from service.workers import PRELOAD

# What the server imports, also to migrate a database, what draws, the commands, and what converts
# meshes.
_MORE = (
    "service.cli.server",
    "service.cli.app",
    "service.jobs.store.migrations.upgrade",
    "service.plans.charts",
    "trimesh",
    "trimesh.exchange.obj",
)


def main() -> None:
    """Import it."""
    for name in (*PRELOAD, *_MORE):
        importlib.import_module(name)


if __name__ == "__main__":
    main()
