"""A SQLite database has one dispatcher: until it gives it back, or its process dies."""

import errno
import subprocess
import sys
import threading

import filelock._unix
import pytest

from service.jobs.dispatch.leadership.leader import DispatcherLock
from service.jobs.errors import DatabaseInUse
from service.jobs.store.sql.database import open_engine

HOLDER = """
import sys
from service.jobs.dispatch.leadership.leader import DispatcherLock
from service.jobs.store.sql.database import open_engine
lock = DispatcherLock(open_engine(sys.argv[1]))
lock.take()
print("held", flush=True)
sys.stdin.read()
"""


@pytest.fixture
def url(tmp_path):
    return f"sqlite:///{tmp_path / 'jobs.sqlite'}"


@pytest.fixture
def lock_of(url):
    """Locks on one database, each with an engine of its own."""
    engines = []

    def made():
        engines.append(open_engine(url))
        return DispatcherLock(engines[-1])

    yield made
    for engine in engines:
        engine.dispose()


def in_thread(work):
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()


def test_a_second_one_is_refused_at_once_until_the_first_gives_it_back(lock_of):
    first, second = lock_of(), lock_of()
    in_thread(first.take)
    with pytest.raises(DatabaseInUse):
        second.take()
    in_thread(first.release)
    second.take()
    assert (second.epoch, second.was_left) == (2, False)
    with pytest.raises(DatabaseInUse):
        first.take()
    second.release()


def test_the_lock_ends_with_its_process(lock_of, url):
    command = [sys.executable, "-c", HOLDER, url]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as holder:
        assert holder.stdout.readline() == b"held\n"
        with pytest.raises(DatabaseInUse):
            lock_of().take()
        holder.kill()
    heir = lock_of()
    heir.take()
    assert heir.was_left
    heir.release()


def test_a_file_system_without_locks_is_refused(lock_of, monkeypatch):
    """A lock that is a file alone would outlive a server that is killed."""

    def missing(_):
        raise OSError(errno.ENOSYS, "no locks")

    monkeypatch.setattr(filelock._unix, "lock_fd_nonblocking", missing)
    with pytest.raises(OSError, match="no locks"):
        lock_of().take()
