"""unchecked_text(): pairs that are not looked at as text, written once for all edits of a scene."""

import threading
from collections import OrderedDict

from planning.domain.geometry.unchecked_pair import UncheckedPair
from service.jobs.json_text import Encoded, encode
from service.scenes.summary_conversion import unchecked_wire

type Pairs = tuple[UncheckedPair, ...]

# As many as there are worlds in a worker; those of a scene's revisions are mostly one and the same.
_MOST = 8
_written: OrderedDict[int, tuple[Pairs, Encoded]] = OrderedDict()
_lock = threading.Lock()


def unchecked_text(pairs: Pairs) -> Encoded:
    """Return the JSON of pairs; of the very tuple that was asked for before, the same text."""
    with _lock:
        known = _written.get(id(pairs))
        # The pairs are held with their text, so that no other tuple has their id.
        if known is None:
            known = pairs, Encoded(encode(unchecked_wire(pairs)))
        _written[id(pairs)] = known
        _written.move_to_end(id(pairs))
        while len(_written) > _MOST:
            _written.popitem(last=False)
        return known[1]
