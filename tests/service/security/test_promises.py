"""Every test that the page on security names exists: a promise without one is none."""

import re
from pathlib import Path

SERVICE = Path(__file__).parents[1]
PAGE = SERVICE.parents[1] / "docs" / "explanation" / "security.md"


def test_every_promise_has_its_test():
    text = PAGE.read_text(encoding="utf-8")
    promised, rest = text.split("## What is not promised")
    rows = [line for line in promised.splitlines() if line.startswith("| ")]
    rows = [row for row in rows if not row.startswith("| promise")]
    assert len(rows) > 15
    for row in rows:
        named = re.findall(r"`([\w/]+\.py)::(\w+)`", row)
        assert named, row
        for file, test in named:
            source = (SERVICE / file).read_text(encoding="utf-8")
            assert re.search(rf"^def {test}\(", source, re.MULTILINE), (file, test)
    assert "::" not in rest


def test_every_test_of_security_is_of_a_promise_or_beside_one():
    """A file of tests that the page does not know of has a promise that is not told."""
    text = PAGE.read_text(encoding="utf-8")
    files = {path.name for path in Path(__file__).parent.glob("test_*.py")} - {Path(__file__).name}
    assert {name for name in files if f"security/{name}" not in text} == set()
