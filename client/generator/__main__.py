"""`python -m client.generator` writes the client's generated modules; `--check` compares."""

import argparse
import subprocess
import sys
from pathlib import Path

from client.generator.document import Document
from client.generator.models import models_text
from client.generator.operations import ASYNC, SYNC, operations_text
from client.generator.requests import requests_text

ROOT = Path(__file__).parents[2]
DOCUMENT = ROOT / "docs" / "reference" / "openapi.json"
FOLDER = ROOT / "client" / "src" / "wayproof_client"


def modules(document: Document) -> dict[str, str]:
    """Return the text of every generated module by its name."""
    texts = {
        "models": models_text(document),
        "requests": requests_text(document),
        "operations": operations_text(document, SYNC),
        "async_operations": operations_text(document, ASYNC),
    }
    return {f"{name}.py": _formatted(text) for name, text in texts.items()}


def _formatted(text: str) -> str:
    """Return a module as `ruff format` has it."""
    command = [sys.executable, "-m", "ruff", "format", "--stdin-filename", str(FOLDER / "it.py")]
    done = subprocess.run(  # noqa: S603  (our own tool)
        [*command, "-"], input=text, capture_output=True, text=True, check=True
    )
    return done.stdout


def differing(document: Document, folder: Path = FOLDER) -> list[str]:
    """Return the names of modules that are not as the document has them."""
    return [
        name
        for name, text in modules(document).items()
        if not (folder / name).is_file() or (folder / name).read_text("utf-8") != text
    ]


def main() -> None:
    """Write the modules, or compare with them."""
    parser = argparse.ArgumentParser(prog="python -m client.generator", description=__doc__)
    parser.add_argument("--check", action="store_true", help="compare, and change nothing")
    document = Document.of(DOCUMENT)
    if parser.parse_args().check:
        found = differing(document)
        sys.stdout.writelines(f"{name} is not as the document has it\n" for name in found)
        sys.exit(1 if found else 0)
    for name, text in modules(document).items():
        (FOLDER / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
