"""Conventions that matter are programs."""

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# A registry or a machine that a committed file must not know. Spelt in parts, as this is one too.
FORBIDDEN = ["pypi" + ".org", "pythonhosted" + ".org", "/work" + "/main", "/root" + "/"]


def tracked(*patterns: str) -> list[Path]:
    done = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", *patterns],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    return [ROOT / line for line in done.stdout.splitlines() if (ROOT / line).is_file()]


@pytest.mark.parametrize("word", FORBIDDEN)
def test_no_file_knows_a_registry_or_this_machine(word: str) -> None:
    guilty = [
        str(path.relative_to(ROOT))
        for path in tracked()
        if word in path.read_text("utf-8", "replace")
    ]
    assert not guilty


def test_one_idea_one_file() -> None:
    long = {
        str(path.relative_to(ROOT)): len(path.read_text().splitlines())
        for path in tracked("planning/*.py", "service/*.py")
    }
    assert {name: lines for name, lines in long.items() if lines > 320} == {}


def test_every_module_says_what_it_is() -> None:
    silent = [
        str(path.relative_to(ROOT))
        for path in tracked("planning/*.py", "service/*.py", "tests/*.py", "benchmarks/*.py")
        if not re.match(r'(#.*\n)*r?"""\S', path.read_text())
    ]
    assert not silent


def test_nothing_is_left_for_later() -> None:
    words = re.compile("TO" + "DO|FIX" + "ME|XX" + "X|Not" + "ImplementedError")
    found = [
        str(path.relative_to(ROOT))
        for path in tracked("planning/*.py", "service/*.py", "tests/*.py", "benchmarks/*.py")
        if words.search(path.read_text())
    ]
    assert not found


def test_every_locked_package_has_hashes() -> None:
    text = (ROOT / "requirements.lock").read_text()
    pins = re.findall(r"^[\w.\-]+(?:\[[\w,]+\])?==[^\n]*", text, re.MULTILINE)
    assert len(pins) > 30
    assert all(pin.rstrip().endswith("\\") for pin in pins)


def test_links_in_the_guide_lead_somewhere() -> None:
    dead = [
        f"{page.relative_to(ROOT)}: {target}"
        for page in tracked("*.md")
        for target in re.findall(r"\]\(([^)#\s]+)", page.read_text())
        if "://" not in target and not (page.parent / target).exists()
    ]
    assert not dead
