"""Tokens of an identity provider: what it signed for this server is let in, and nothing else."""

import asyncio
import json
import logging
import threading
from datetime import UTC, datetime
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import httpx
import jwt
import pytest
from cryptography.hazmat.primitives.asymmetric import ec, rsa
from pydantic import ValidationError

from service.app import create_app
from service.security.scopes import Scope
from service.security.tokens import TokenVerifier, scopes_of
from service.settings import Settings
from tests.service.conftest import TestClient

ISSUER, AUDIENCE = "https://login.example.org/", "wayproof"
RSA, OTHER = (rsa.generate_private_key(public_exponent=65537, key_size=2048) for _ in range(2))
CURVE = ec.generate_private_key(ec.SECP256R1())
FAR = 4_000_000_000


def published(**keys):
    """The key set of a provider."""
    kinds = {rsa.RSAPrivateKey: jwt.algorithms.RSAAlgorithm, ec.EllipticCurvePrivateKey: None}
    found = []
    for name, key in keys.items():
        algorithm = next(kind for known, kind in kinds.items() if isinstance(key, known))
        algorithm = algorithm or jwt.algorithms.ECAlgorithm
        found.append({**algorithm.to_jwk(key.public_key(), as_dict=True), "kid": name})
    return {"keys": found}


def claims(**changes):
    plain = {"iss": ISSUER, "aud": AUDIENCE, "sub": "u1", "exp": FAR, "scope": "wayproof:plan"}
    return {name: claim for name, claim in (plain | changes).items() if claim is not None}


def signed(key=RSA, name="a", algorithm="RS256", **changes):
    return jwt.encode(claims(**changes), key, algorithm=algorithm, headers={"kid": name})


class Provider:
    """An identity provider that publishes what it is told to, and counts how often."""

    def __init__(self, **keys):
        self.keys = published(**keys)
        self.issuer = ISSUER
        self.asked = 0
        self.is_away = False

    def __call__(self, request):
        if self.is_away:
            raise httpx.ConnectError("away")
        if request.url.path.endswith("openid-configuration"):
            where = {"issuer": self.issuer, "jwks_uri": f"{ISSUER}keys"}
            return httpx.Response(200, json=where)
        self.asked += 1
        return httpx.Response(200, json=self.keys)


def found(provider, *texts, clock=lambda: 0.0):
    """What a verifier says of some texts, one after the other."""

    async def run():
        async with httpx.AsyncClient(transport=httpx.MockTransport(provider)) as http:
            verifier = TokenVerifier(ISSUER, AUDIENCE, http, clock)
            return [await verifier.find(text) for text in texts]

    return asyncio.run(run())


@pytest.mark.parametrize(("key", "algorithm"), [(RSA, "RS256"), (CURVE, "ES256")])
def test_a_token_of_the_provider_is_who_it_says(key, algorithm):
    text = signed(key, algorithm=algorithm, preferred_username="ada")
    [token] = found(Provider(a=key), text)
    assert (token.id, token.name, token.scopes) == ("u1", "ada", {Scope.PLAN})
    assert token.is_valid(datetime.now(UTC))
    assert token.allows(Scope.PLAN)
    assert not token.allows(Scope.EXECUTE)


def forged():
    """Tokens that are not the provider's, or not for this server."""
    good = signed()
    head, _, signature = good.split(".")
    public = RSA.public_key()
    secret = json.dumps(jwt.algorithms.RSAAlgorithm.to_jwk(public))
    yield "another key", signed(OTHER)
    yield "another key's name", signed(OTHER, name="b")
    yield "no signature", jwt.encode(claims(), None, algorithm="none", headers={"kid": "a"})
    yield "signed by what is public", signed(secret.encode(), algorithm="HS256")
    yield "another body", f"{head}.{signed(sub='root').split('.')[1]}.{signature}"
    yield "cut", good[:-4]
    yield "another audience", signed(aud="other")
    yield "no audience", signed(aud=None)
    yield "another issuer", signed(iss="https://evil.example.org/")
    yield "issuer without its slash", signed(iss=ISSUER.rstrip("/"))
    yield "expired", signed(exp=1_000_000_000)
    yield "never expires", signed(exp=None)
    yield "expires beyond all dates", signed(exp=10**30)
    yield "not yet", signed(nbf=FAR)
    yield "nobody's", signed(sub=None)
    yield "a number's", jwt.encode(claims() | {"sub": 7}, RSA, "RS256", headers={"kid": "a"})
    yield "too long", signed(more="x" * 20_000)
    yield "no token", "a.b.c"
    yield "empty", "."


FORGED = dict(forged())


@pytest.mark.parametrize("what", FORGED)
def test_what_the_provider_did_not_sign_for_this_server_is_none(what):
    assert found(Provider(a=RSA), FORGED[what]) == [None]


def test_symmetric_keys_that_a_provider_publishes_verify_nothing():
    provider = Provider(a=RSA)
    secret = "c2VjcmV0LXNlY3JldC1zZWNyZXQtc2VjcmV0LXNlY3JldA"
    provider.keys["keys"].append({"kty": "oct", "k": secret, "kid": "s", "alg": "HS256"})
    text = signed(b"secret-secret-secret-secret-secret", name="s", algorithm="HS256")
    assert found(provider, text, signed())[0] is None


def test_a_new_key_is_fetched_and_names_that_there_are_not_cost_the_provider_nothing():
    provider, now = Provider(a=RSA), [0.0]
    texts = [signed(), *(signed(OTHER, name=f"x{i}") for i in range(50))]

    async def run():
        async with httpx.AsyncClient(transport=httpx.MockTransport(provider)) as http:
            verifier = TokenVerifier(ISSUER, AUDIENCE, http, lambda: now[0])
            answers = [await verifier.find(text) for text in texts]
            assert [token is not None for token in answers] == [True] + [False] * 50
            assert provider.asked == 1
            provider.keys = published(b=OTHER)
            now[0] = 60.0
            assert await verifier.find(signed(OTHER, name="b")) is not None
            assert await verifier.find(signed()) is None  # its key is not published any more
            provider.is_away = True
            now[0] = 10_000.0
            # Keys that were read last hold while the provider is away.
            assert await verifier.find(signed(OTHER, name="b")) is not None

    asyncio.run(run())


def test_a_provider_that_says_it_is_another_one_gives_no_keys(caplog):
    provider = Provider(a=RSA)
    provider.issuer = "https://evil.example.org/"
    with caplog.at_level(logging.WARNING):
        assert found(provider, signed()) == [None]
    assert "could not be fetched" in caplog.text


@pytest.mark.parametrize(
    ("said", "scopes"),
    [
        ({"scope": "openid wayproof:read wayproof:plan"}, {Scope.READ, Scope.PLAN}),
        ({"scp": ["wayproof:execute"]}, {Scope.EXECUTE}),
        ({"roles": ["wayproof:admin", "x"], "scope": ""}, {Scope.ADMIN}),
        ({"scope": "read plan admin"}, set()),
        ({"scope": 7, "roles": None}, set()),
        ({}, set()),
    ],
)
def test_scopes_are_those_that_name_this_program(said, scopes):
    assert scopes_of(said) == scopes


class _Site(BaseHTTPRequestHandler):
    """A provider that listens."""

    def do_GET(self):
        url = f"http://127.0.0.1:{self.server.server_port}/"
        where = {"issuer": url, "jwks_uri": f"{url}keys"}
        body = json.dumps(published(a=RSA) if self.path == "/keys" else where).encode()
        self.send_response(200)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_):
        pass


@pytest.fixture
def provider():
    with ThreadingHTTPServer(("127.0.0.1", 0), _Site) as site:
        threading.Thread(target=site.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{site.server_port}/"
        site.shutdown()


def test_a_server_lets_tokens_in_beside_keys(tmp_path, provider, caplog):
    given = {"oidc_issuer": provider, "oidc_audience": AUDIENCE}
    settings = Settings(engine="inline", data_dir=tmp_path, auth="keys", **given)
    text = signed(iss=provider, scope="wayproof:read", email="ada@example.org")
    with TestClient(create_app(settings)) as client, caplog.at_level(logging.INFO):

        def status(method, path, text):
            headers = {"Authorization": f"Bearer {text}"}
            return client.request(method, path, headers=headers, json={}).status_code

        assert status("GET", "/v1/plans", text) == 200
        assert status("POST", "/v1/plans", text) == 403
        assert status("GET", "/v1/plans", signed(OTHER, iss=provider)) == 401
        assert status("GET", "/v1/plans", "wp_000000000000_" + "A" * 43) == 401
    assert '"caller": "ada@example.org"' in caplog.text
    assert text.rsplit(".", 1)[1] not in caplog.text


@pytest.mark.parametrize(
    ("given", "missing"),
    [
        ({"oidc_audience": AUDIENCE}, "auth=keys"),
        ({"auth": "keys"}, "oidc_audience"),
        ({"auth": "keys", "oidc_audience": AUDIENCE, "oidc_issuer": "http://example.org"}, "match"),
    ],
)
def test_settings_that_would_let_anyone_in_are_refused(given, missing):
    with pytest.raises(ValidationError, match=missing):
        Settings(**{"oidc_issuer": ISSUER, **given})
