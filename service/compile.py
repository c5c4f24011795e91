"""`python -m service.compile`: import all that servers and workers import, once.

Python compiles what it imports and keeps that (PEP 3147), where it may write beside the modules:
without it the first start takes three times as long. Installers may leave it to the first import.
"""

import compileall
import importlib
from importlib.util import find_spec

from service.workers import PRELOAD

# What the server imports, also to migrate a database, what draws, the commands, and what converts
# meshes.
_MORE = (
    "service.cli.server",
    "service.cli.app",
    "service.jobs.store.sql.migrations.upgrade",
    "service.plans.delivery.charts",
    "trimesh",
    "trimesh.exchange.obj",
)


# What is imported only once it is needed, and takes long to import.
_LATE = ("toppra",)


def main() -> None:
    """Import it, and compile what is imported late."""
    for name in (*PRELOAD, *_MORE):
        importlib.import_module(name)
    for name in _LATE:
        found = find_spec(name)
        for folder in (found and found.submodule_search_locations) or ():
            compileall.compile_dir(folder, quiet=2)


if __name__ == "__main__":
    main()
