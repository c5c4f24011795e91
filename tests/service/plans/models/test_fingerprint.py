"""An idempotency key of version 0.1 stands for its request still: what was added since is left out.

A field that is added to a request without `ADDED` fails here.
"""

import json
from pathlib import Path

from service.api.fingerprint import fingerprint
from service.plans.models.request import PlanRequest

STORED = Path(__file__).parents[3] / "golden" / "service" / "database-0.1.sql"


def stored_requests():
    """Requests of plans as version 0.1 wrote them down, every field with its default."""
    text, mark = STORED.read_text(encoding="utf-8").replace("''", "'"), '"request":'
    pieces = text.split(mark)[1:]
    found = [json.JSONDecoder().raw_decode(piece)[0] for piece in pieces if piece[0] == "{"]
    return [one for one in found if "search" in one and "goal" in one]


def names(content, path=()):
    """Paths of all members of a document."""
    found = {path}
    if isinstance(content, dict):
        for name, part in content.items():
            found |= names(part, (*path, name))
    return found


def test_the_fields_of_version_0_1_alone_count_where_no_other_says_anything():
    requests = stored_requests()
    assert requests
    for stored in requests:
        # The one field that has another name now (`service/plans/submit.py`).
        stored["ik"]["allowed_time"] = stored["ik"].pop("time_limit")
        assert names(fingerprint(PlanRequest.model_validate(stored))) == names(stored)
