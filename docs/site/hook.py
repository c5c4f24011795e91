"""What mkdocs calls: adds the generated pages, and leads links out of `docs/` where they can go."""

import re
from pathlib import Path, PurePosixPath
from posixpath import normpath
from typing import Any

from mkdocs.structure.files import File, Files

from docs.site.error_pages import error_pages
from docs.site.http_pages import http_pages
from docs.site.source_pages import source_pages

_ROOT = Path(__file__).parents[2]
# Pages that are beside `docs/`, and where they are in the site.
_BESIDE = {
    "README.md": "index.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
}
_LINK = re.compile(r"\[([^\]]*)\]\(([^)\s]+)\)")


def on_files(files: Files, config: Any) -> Files:
    """Add pages that are generated and those that lie beside `docs/`."""
    beside = ((page, (_ROOT / name).read_text(encoding="utf-8")) for name, page in _BESIDE.items())
    api = http_pages(_ROOT / "docs" / "reference" / "openapi.json")
    for path, text in (
        *beside,
        *api,
        *error_pages(),
        *source_pages(),
        ("decisions/index.md", _decisions()),
    ):
        files.append(File.generated(config, path, content=text))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Return the page with links that lead somewhere in the site."""
    path = PurePosixPath(page.file.src_uri)
    of_root = {there: name for name, there in _BESIDE.items()}
    folder = PurePosixPath() if str(path) in of_root else "docs" / path.parent

    def lead(link: re.Match[str]) -> str:
        text, target = link[1], link[2]
        place, mark, anchor = target.partition("#")
        if not place or ":" in place:
            return link[0]
        there = normpath(folder / place)
        if there in _BESIDE:
            return f"[{text}]({_relative(_BESIDE[there], path)}{mark}{anchor})"
        if there == "docs/decisions":
            return f"[{text}]({_relative('decisions/index.md', path)})"
        if there.startswith("docs/"):
            return f"[{text}]({_relative(there.removeprefix('docs/'), path)}{mark}{anchor})"
        return text if text.startswith("`") else f"`{text}`"  # a source, which the site has not

    return _LINK.sub(lead, markdown)


def _relative(target: str, page: PurePosixPath) -> str:
    return "../" * (len(page.parts) - 1) + target


def _decisions() -> str:
    rows = [
        f"- [{_title(file)}]({file.name})"
        for file in sorted((_ROOT / "docs" / "decisions").glob("0*.md"))
    ]
    return "# Decisions\n\nWhy things are as they are, in order.\n\n" + "\n".join(rows) + "\n"


def _title(file: Path) -> str:
    return file.read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ")
