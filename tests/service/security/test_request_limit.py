"""Too many requests are refused, each caller's for themselves."""

from datetime import UTC, datetime

import pytest
from pydantic import ValidationError

from service.app import create_app
from service.jobs.store.sql.database import open_engine
from service.security.keys import KeyStore
from service.security.scopes import Scope
from service.settings import Settings
from tests.service.conftest import TestClient


def limited(folder, **settings):
    """A server that lets in three requests a day."""
    chosen = Settings(engine="inline", data_dir=folder, rate_limit="3/day", **settings)
    return TestClient(create_app(chosen))


def test_the_request_after_the_last_one_is_refused(tmp_path):
    with limited(tmp_path) as client:
        # What is refused for another reason is a request too.
        statuses = [client.get(path).status_code for path in ("/v1/plans", "/v1/plans?x=1", "/v2")]
        assert statuses == [200, 422, 404]
        answer = client.get("/v1/plans")
        assert (answer.status_code, answer.json()["code"]) == (429, "rate_limited")
        assert 1 <= int(answer.headers["retry-after"]) <= 2 * 86400
        assert answer.json()["evidence"]["limit"] == "3/day"
        assert client.get("/healthz").status_code == 200
        assert client.get("/readyz").status_code == 200


def test_there_is_no_limit_unless_one_is_set(client):
    assert {client.get("/v1/plans").status_code for _ in range(50)} == {200}


def test_keys_are_counted_apart_and_guesses_by_address(tmp_path):
    with limited(tmp_path, auth="keys") as client:
        engine = open_engine(client.app.state.settings.url)
        store, now = KeyStore(engine), datetime.now(UTC)
        keys = [store.create(name, [Scope.READ], now).text for name in "ab"]
        engine.dispose()
        client.portal.call(client.app.state.callers.keys.read)

        def status(key):
            headers = {"Authorization": f"Bearer {key}"}
            return client.get("/v1/plans", headers=headers).status_code

        assert [status(keys[0]) for _ in range(4)] == [200, 200, 200, 429]
        assert [status(f"wp_{i:012}_{'A' * 43}") for i in range(4)] == [401, 401, 401, 429]
        assert [status(keys[1]) for _ in range(4)] == [200, 200, 200, 429]


@pytest.mark.parametrize("wrong", ["x", "600", "600/eon", "-1/minute", "many/minute"])
def test_nonsense_is_no_limit(wrong):
    with pytest.raises(ValidationError, match="such as 600/minute"):
        Settings(rate_limit=wrong)
