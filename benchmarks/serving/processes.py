"""Processes and their files, as /proc has them."""

import os
import signal
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Process:
    """A process that cannot be taken for a later one of the same number.

    Attributes:
        pid: Its number.
        began: When it began, in clock ticks since the machine did.
    """

    pid: int
    began: int

    @property
    def is_alive(self) -> bool:
        """Whether it runs, or is stopped; one that has ended and was not waited for does not."""
        found = _stat(self.pid)
        return found is not None and found[1] == self.began and found[2] != "Z"

    @property
    def wants_to_run(self) -> bool:
        """Whether it waits for nothing but a processor or a disk, if it is alive."""
        found = _stat(self.pid)
        return found is not None and found[2] in "RD"

    @property
    def cpu_seconds(self) -> float:
        """The processor time that it has used [s]; 0 once it is gone."""
        try:
            return cpu_seconds(self.pid) if self.is_alive else 0.0
        except OSError:
            return 0.0

    def send(self, number: signal.Signals) -> None:
        """Send a signal; a process that is gone gets none."""
        if self.is_alive:
            with suppress(ProcessLookupError):
                os.kill(self.pid, number)


def descendants(pid: int) -> list[tuple[Process, int]]:
    """Return the processes below one, in order of their numbers, each with its parent's number."""
    parents: dict[int, int] = {}
    found: dict[int, Process] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal() and (stat := _stat(int(entry.name))) is not None:
            parents[int(entry.name)] = stat[0]
            found[int(entry.name)] = Process(int(entry.name), stat[1])
    return [
        (found[child], parents[child]) for child in sorted(found) if _is_below(child, pid, parents)
    ]


def workers(pid: int) -> list[Process]:
    """Return what runs the tasks of a server: children of its forkserver, and what they started."""
    return [process for process, parent in descendants(pid) if parent != pid]


def open_files(pid: int) -> Counter[str]:
    """Return how many files a process has open, by kind: pipe, socket, anon_inode, file."""
    kinds: Counter[str] = Counter()
    for entry in Path(f"/proc/{pid}/fd").iterdir():
        with suppress(OSError):
            name = str(entry.readlink())
            kinds["file" if name.startswith("/") else name.partition(":")[0]] += 1
    return kinds


def resident(pid: int) -> float:
    """Return the memory of a process and of those below it, shared pages by their share [MiB]."""
    total = 0
    for one in (pid, *(process.pid for process, _ in descendants(pid))):
        with suppress(OSError):
            for line in Path(f"/proc/{one}/smaps_rollup").read_text().splitlines():
                if line.startswith("Pss:"):
                    total += int(line.split()[1])
    return total / 1024


def cpu_seconds(pid: int) -> float:
    """Return the processor time that a living process has used [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _is_below(pid: int, top: int, parents: dict[int, int]) -> bool:
    while (pid := parents.get(pid, 0)) != 0:
        if pid == top:
            return True
    return False


def _stat(pid: int) -> tuple[int, int, str] | None:
    """Return parent, beginning and state of a process, None if there is none."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    except OSError:
        return None
    return int(fields[1]), int(fields[19]), fields[0]
