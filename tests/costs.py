"""What the tests cost, by folder: `make costs`.

Seconds of CPU and not of waiting: they are nearly the same whatever else the machine does. They
count the processes that a test starts and waits for, not those that go on after it, and what is
imported or loaded once counts for the test that comes first.
"""

import os
from collections import Counter
from collections.abc import Generator
from pathlib import PurePosixPath

import pytest

NUM_SLOWEST = 20


def spent() -> float:
    """Return the seconds of CPU that this process and its ended children have used so far."""
    return sum(os.times()[:4])


def folder_of(test: str) -> str:
    return "/".join(PurePosixPath(test.partition("::")[0]).parts[:2])


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    item.stash[_BEGIN] = spent()
    return (yield)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_teardown(item: pytest.Item) -> None:
    """Note what setup and call took: what is known when the last report is made."""
    item.user_properties.append(("cpu", spent() - item.stash[_BEGIN]))


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    tests = {
        report.nodeid: seconds
        for reports in terminalreporter.stats.values()
        for report in reports
        if getattr(report, "when", "") == "teardown"
        for name, seconds in report.user_properties
        if name == "cpu"
    }
    folders, counts = Counter[str](), Counter[str]()
    for test, seconds in tests.items():
        folders[folder_of(test)] += seconds
        counts[folder_of(test)] += 1
    write = terminalreporter.write_line
    write("\n| folder | tests | CPU [s] |\n|---|---:|---:|")
    for folder, seconds in folders.most_common():
        write(f"| `{folder}` | {counts[folder]} | {seconds:.0f} |")
    write(f"| all | {counts.total()} | {folders.total():.0f} |\n")
    for test, seconds in Counter(tests).most_common(NUM_SLOWEST):
        write(f"{seconds:6.1f} s  {test}")


_BEGIN = pytest.StashKey[float]()
