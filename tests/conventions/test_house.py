"""Conventions that matter are programs."""

import re
import subprocess
from collections import Counter, defaultdict
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# Each stage has a file of what it is asked.
TWICE = {"request"}
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


def test_no_folder_of_planning_takes_long_to_read() -> None:
    entries: defaultdict[Path, set[Path]] = defaultdict(set)
    for path in tracked("planning/*"):
        way = [path, *path.relative_to(ROOT).parents]
        inner = path
        for folder in way[1:-1]:
            entries[folder].add(inner.relative_to(ROOT) if inner.is_absolute() else inner)
            inner = folder
    large = {str(folder): len(names) for folder, names in entries.items() if len(names) > 17}
    assert large == {}


def test_the_name_of_a_module_or_class_of_planning_means_one_thing() -> None:
    files = [path for path in tracked("planning/*.py") if path.name != "__init__.py"]
    modules = Counter(path.stem for path in files)
    classes = Counter(
        name
        for path in files
        for name in re.findall(r"^class ([A-Z]\w*)", path.read_text(), re.MULTILINE)
    )
    assert {name for name, count in modules.items() if count > 1} <= TWICE
    assert {name for name, count in classes.items() if count > 1} <= TWICE


def test_types_of_arrays_are_imported_from_the_file_that_has_them() -> None:
    import_line = re.compile(
        r"^from (planning\S+) import .*\b(?:Array|Indices|Flags)\b", re.MULTILINE
    )
    found = {
        (str(path.relative_to(ROOT)), module)
        for path in tracked("planning/*.py")
        for module in import_line.findall(path.read_text())
    }
    assert len(found) > 200
    assert {file for file, module in found if module != "planning.domain.arrays"} == set()


def test_docs_name_places_that_exist() -> None:
    place = re.compile(r"`((?:planning|service|tests|benchmarks)/[\w/.-]*\w)/?`")
    named = {
        (str(path.relative_to(ROOT)), found)
        for path in tracked("README.md", "CONTRIBUTING.md", "docs/*.md")
        if "decisions" not in path.parts  # they speak of their time
        for found in place.findall(path.read_text())
    }
    assert len(named) > 30
    assert {(guide, found) for guide, found in named if not (ROOT / found).exists()} == set()


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
