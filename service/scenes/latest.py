"""Latest: revisions that are known to be the latest of their scenes, so that none is read again.

To find the latest revision takes reads of two tables, and of a document that may have megabytes.
Only this server writes either table, so what it has read stays true until it writes.
"""

from collections import OrderedDict
from collections.abc import Generator
from contextlib import contextmanager

from service.scenes.records import SceneRecord

# Documents may be large; who plans, plans in few scenes at a time.
_MOST = 8


class Latest:
    """Remembers the latest revisions of a few scenes; belongs to one event loop."""

    def __init__(self) -> None:
        """Know none."""
        self._known: OrderedDict[str, SceneRecord] = OrderedDict()
        self._num_changes = 0

    def of(self, identifier: str) -> SceneRecord | None:
        """Return the latest revision of a scene if it is known."""
        record = self._known.get(identifier)
        if record is not None:
            self._known.move_to_end(identifier)
        return record

    def look(self) -> int:
        """Begin to read a revision; `keep` wants what this returns."""
        return self._num_changes

    def keep(self, record: SceneRecord, look: int) -> None:
        """Remember what was read, unless something has changed since that look began."""
        if look == self._num_changes:
            self._known[record.id] = record
            if len(self._known) > _MOST:
                self._known.popitem(last=False)

    @contextmanager
    def changing(self, identifier: str) -> Generator[None]:
        """Change a scene, or begin to move something in it; what is read meanwhile is not kept."""
        self._forget(identifier)
        try:
            yield
        finally:
            self._forget(identifier)

    def _forget(self, identifier: str) -> None:
        self._num_changes += 1
        self._known.pop(identifier, None)
