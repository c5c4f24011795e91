"""What tasks about executions say of themselves."""

from service.executions.tasks import REPLAY_MOTIONS
from service.jobs.task import artifacts_of


def test_a_replay_reads_the_documents_of_all_its_scenes():
    """A host that lacks one, or has lost it, is given it."""
    motions = [{"scene": {"digest": "d", "document": name}} for name in ("one", "two", "one")]
    assert artifacts_of(REPLAY_MOTIONS.name, {"motions": motions}) == ["one", "two"]
