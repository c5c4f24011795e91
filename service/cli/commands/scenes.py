"""wayproof scenes: the scenes there are."""

from rich.table import Table

from service.cli.options import AsJson, ServerUrl
from service.cli.output import console, print_json
from service.cli.scene_source import bundled_scenes
from service.cli.session import session


def scenes(*, server: ServerUrl = None, as_json: AsJson = False) -> None:
    """List the bundled scenes, or with --server those that were posted to it, newest first."""
    if server is None:
        names = bundled_scenes()
        if as_json:
            print_json([{"name": name} for name in names])
        else:
            console.print("\n".join(names))
        return
    with session(server) as client:
        posted = list(client.all_scenes())
    if as_json:
        print_json([one.model_dump(mode="json") for one in posted])
        return
    table = Table()
    for head in ("id", "name", "revision", "posted (UTC)"):
        table.add_column(head)
    for one in posted:
        table.add_row(one.id, one.name, str(one.revision), f"{one.created_at:%Y-%m-%d %H:%M}")
    console.print(table)
