"""Files that other processes see either whole or not at all."""

import tempfile
from pathlib import Path


def write_whole(target: Path, text: str) -> None:
    """Write a text file in one step; its folder is created if needed.

    Raises:
        OSError: It cannot be written.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=".part") as part:
        written = Path(part) / target.name
        written.write_text(text, "utf-8")
        written.replace(target)
