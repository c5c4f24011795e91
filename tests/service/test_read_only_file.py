"""While the database's files can be read alone, that is told; nothing is lost, and work goes on."""

import subprocess

import httpx
import pytest

from tests.profiles import only_campaign
from tests.service.servers import ARM, request_of, server


def immutable(files, *, is_so):
    """Set or clear the flag of chattr(1), which keeps root from writing as well."""
    change = ["chattr", "+i" if is_so else "-i", *map(str, files)]
    return subprocess.run(change, check=False, capture_output=True).returncode == 0


@only_campaign("10 s; and not on tmpfs, where files that are open can still be written")
def test_a_database_that_can_only_be_read_is_told_and_loses_nothing(tmp_path):
    with (
        server(tmp_path) as running,
        httpx.Client(base_url=running.url, timeout=60, trust_env=False) as http,
    ):
        scene = running.client.add_scene(ARM)
        request = request_of(scene, seed=1)
        assert http.post("/v1/plans?wait=30", json=request).json()["state"] == "succeeded"
        database = tmp_path / "state" / "wayproof.sqlite"
        # Not its index, which is mapped into memory: to write there would be a SIGBUS.
        files = [database, database.with_name(f"{database.name}-wal")]
        if not immutable(files, is_so=True):
            pytest.skip("no file can be made immutable here")
        try:
            refused = http.post("/v1/plans?wait=30", json=request)
            read = http.get("/v1/plans")
        finally:
            assert immutable(files, is_so=False)
        assert (refused.status_code, refused.json()["code"]) == (503, "database_unavailable")
        assert int(refused.headers["retry-after"]) > 0
        assert (read.status_code, len(read.json()["items"])) == (200, 1)
        assert http.post("/v1/plans?wait=30", json=request).json()["state"] == "succeeded"
        assert len(http.get("/v1/plans").json()["items"]) == 2
