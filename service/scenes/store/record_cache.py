"""Records of scenes that need not be read again: those last asked for, and the latest revisions."""

import threading
from collections import OrderedDict
from collections.abc import Callable, Generator
from contextlib import contextmanager

from service.scenes.store.records import SceneRecord

# Of text [characters]; a scene of ten thousand boxes has four million.
_MOST_CHARS = 48_000_000
# Documents may be large; who plans, plans in few scenes at a time.
_MOST = 8

type Key = tuple[str, int]


class RecentScenes:
    """Records by scene and revision, of which none ever changes; for several threads."""

    def __init__(self, most_chars: int = _MOST_CHARS) -> None:
        """Hold so much text at most, and the last record whatever its size."""
        self._most = most_chars
        self._total = 0
        self._records: OrderedDict[Key, SceneRecord] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, identifier: str, revision: int) -> SceneRecord | None:
        """Return a record if it is here."""
        with self._lock:
            found = self._records.get((identifier, revision))
            if found is not None:
                self._records.move_to_end((identifier, revision))
            return found

    def put(self, record: SceneRecord) -> None:
        """Keep a record, and forget those that were not asked for longest."""
        key = record.id, record.revision
        with self._lock:
            if key not in self._records:
                self._records[key] = record
                self._total += record.num_chars
            while self._total > self._most and len(self._records) > 1:
                _, gone = self._records.popitem(last=False)
                self._total -= gone.num_chars


class Latest:
    """Remembers the latest revisions of a few scenes; belongs to one event loop.

    To find the latest revision takes reads of two tables, and of a document that may have
    megabytes. Where only this server writes either table, what it has read stays true until it
    writes; where others do, nothing is remembered.

    Attributes:
        on_change: Called with the id of a scene once it was changed here, or something moves in it.
    """

    def __init__(self, *, is_shared: bool = False) -> None:
        """Know none.

        Args:
            is_shared: Whether other servers may write as well.
        """
        self.on_change: Callable[[str], None] | None = None
        self._is_shared = is_shared
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
        if look == self._num_changes and not self._is_shared:
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
            if self.on_change is not None:
                self.on_change(identifier)

    def _forget(self, identifier: str) -> None:
        self._num_changes += 1
        self._known.pop(identifier, None)
