"""Who is waited for leaves SQLite's log as it is, as long as others come that wait for the disk."""

import pytest

from service.jobs.store.job_store import JobStore
from service.jobs.store.sql.database import open_engine


@pytest.mark.parametrize(("is_durable", "most_pages"), [(True, 1000), (False, 4000)])
def test_pages_are_moved_by_what_waits_for_the_disk(tmp_path, is_durable, most_pages):
    engine = open_engine(f"sqlite:///{tmp_path}/jobs.sqlite")
    store = JobStore(engine)
    store.open()
    with store.keeping_connection():
        for each in (not is_durable, is_durable):
            with store.transaction(is_durable=each) as connection:
                found = connection.exec_driver_sql("PRAGMA wal_autocheckpoint").scalar()
    assert found == most_pages
    engine.dispose()
