"""RecentScenes: the records that were last asked for, which need not be read again."""

import threading
from collections import OrderedDict

from service.scenes.records import SceneRecord

# Of text [characters]; a scene of ten thousand boxes has four million.
_MOST_CHARS = 48_000_000

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
