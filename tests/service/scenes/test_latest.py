"""What is remembered of a scene is what would be read."""

from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace

from service.scenes.store.record_cache import _MOST, Latest


def record(identifier, revision=1):
    return SimpleNamespace(id=identifier, revision=revision)


def test_what_was_read_in_peace_is_kept():
    latest = Latest()
    look = latest.look()
    assert latest.of("a") is None
    latest.keep(record("a"), look)
    latest.keep(record("b"), look)
    assert latest.of("a") == record("a")
    with latest.changing("a"):
        assert latest.of("a") is None
        assert latest.of("b") == record("b")


def test_what_was_read_while_something_changed_is_not_kept():
    """A read may begin before a change, or in it, and end in it, or after."""
    for begin, end in ((0, 1), (0, 2), (1, 1), (1, 2)):
        latest, looks = Latest(), []

        def at(moment, begin=begin, end=end, latest=latest, looks=looks):
            if moment == begin:
                looks.append(latest.look())
            if moment == end:
                latest.keep(record("a"), looks[0])

        at(0)
        with latest.changing("a"):
            at(1)
        at(2)
        assert latest.of("a") is None, (begin, end)


def test_a_change_that_fails_is_a_change():
    latest = Latest()
    latest.keep(record("a"), latest.look())
    with suppress(FileNotFoundError), latest.changing("a"):
        latest.keep(record("a"), latest.look())
        Path("/never/there").stat()
    assert latest.of("a") is None


def test_few_are_kept_and_those_that_are_asked_for():
    latest = Latest()
    for i in range(_MOST + 3):
        latest.keep(record(str(i)), latest.look())
        assert latest.of("0") is not None
    kept = [i for i in range(_MOST + 3) if latest.of(str(i)) is not None]
    assert kept == [0, *range(4, _MOST + 3)]
