"""The golden corpus of requests: what the service answers may not change when its code moves.

`python -m tests.golden.service` records the answers anew; with `--check` it says which differ.
"""

import argparse
import json
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from tests.golden.differences import differences
from tests.golden.service.answers import answers
from tests.golden.service.machine import machine, reconciled

FILE = Path(__file__).with_name("answers.json")
REWRITE = "python -m tests.golden.service"
_MOST_LINES = 8
_MACHINE = "<machine>"


def main() -> None:
    """Record answers, or compare with those that are recorded."""
    parser = argparse.ArgumentParser(prog=REWRITE, description=__doc__)
    parser.add_argument("--check", action="store_true", help="compare, and change nothing")
    is_check = parser.parse_args().check
    found = dict(answers())
    if not is_check:
        FILE.write_text(text_of({_MACHINE: machine(), **found}), encoding="utf-8")
        return
    told = changes_since_recorded(found)
    sys.stdout.writelines(f"{line}\n" for line in told)
    sys.exit(1 if told else 0)


def recorded() -> dict[str, Any]:
    """Return the answers that are recorded, by the names of the calls."""
    return {name: told for name, told in _file().items() if name != _MACHINE}


def changes_since_recorded(found: dict[str, Any]) -> list[str]:
    """Return lines that say which answers differ from the recorded ones and how.

    Where the file was recorded on another kind of machine, the last digits of numbers, and digests
    of what has such numbers, may differ.
    """
    old = recorded()
    if _file()[_MACHINE] != machine():
        sys.stdout.write("recorded on another kind of machine: numbers are compared to 1 %\n")
        found = reconciled(old, found)
    return changes(old, found)


def text_of(found: dict[str, Any]) -> str:
    """Return the text of a file of answers: one line for each."""
    lines = [
        f"{json.dumps(name)}: {json.dumps(told, sort_keys=True)}" for name, told in found.items()
    ]
    return "{\n" + ",\n".join(lines) + "\n}\n"


def changes(old: dict[str, Any], new: dict[str, Any]) -> list[str]:
    """Return lines that say which answers differ and how."""
    return [
        line for name in {**old, **new} for line in _of_call(name, old.get(name), new.get(name))
    ]


def _file() -> dict[str, Any]:
    found: dict[str, Any] = json.loads(FILE.read_text(encoding="utf-8"))
    return found


def _of_call(name: str, old: Any, new: Any) -> Iterable[str]:
    if old is None or new is None:
        return [f"{name}: is {'new' if old is None else 'gone'}"]
    told = [f"{name}{pointer} {how}" for pointer, how in differences(old, new)]
    if len(told) > _MOST_LINES:
        told[_MOST_LINES:] = [f"{name}: and {len(told) - _MOST_LINES} differences more"]
    return told


if __name__ == "__main__":
    main()
