"""The OpenAPI document as it is committed: clients are generated from it, so it changes knowingly.

`python -m tests.golden.openapi` writes it anew; with `--check` it says where it differs.
"""

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from service.app import create_app
from service.settings import Settings
from tests.golden.differences import differences

FILE = Path(__file__).parents[2] / "docs" / "reference" / "openapi.json"
REWRITE = "python -m tests.golden.openapi"


def text_of(document: dict[str, Any]) -> str:
    """Return the text of a document: keys sorted, so that a move of code changes no line."""
    return json.dumps(document, indent=1, sort_keys=True, ensure_ascii=False) + "\n"


def served() -> dict[str, Any]:
    """Return the document that the service serves."""
    return create_app(Settings(engine="inline")).openapi()


def changes(document: dict[str, Any], file: Path = FILE) -> list[str]:
    """Return a line for each part of a document that is not as in the committed file."""
    committed = json.loads(file.read_text(encoding="utf-8"))
    new = json.loads(text_of(document))
    return [f"{pointer} {how}" for pointer, how in differences(committed, new)]


def main() -> None:
    """Write the committed file, or compare with it."""
    parser = argparse.ArgumentParser(prog=REWRITE, description=__doc__)
    parser.add_argument("--check", action="store_true", help="compare, and change nothing")
    is_check = parser.parse_args().check
    document = served()
    if not is_check:
        FILE.parent.mkdir(parents=True, exist_ok=True)
        FILE.write_text(text_of(document), encoding="utf-8")
        return
    found = changes(document)
    sys.stdout.writelines(f"{line}\n" for line in found)
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
