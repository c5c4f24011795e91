"""API keys: secrets that are told once, and kept as digests in the service's database.

A key is `wp_<id>_<secret>`; the id finds its row. The secret has 256 random bits, so one round of
sha256 protects it as well as a slow hash does a password: there is nothing to guess.
"""

import hashlib
import hmac
import logging
import re
import secrets
from collections.abc import Iterable
from dataclasses import dataclass, field
from datetime import datetime, timedelta

from sqlalchemy import Column, Engine, MetaData, Row, String, Table, insert, select, update

from planning.errors import ProblemInvalid, UnknownName
from service.errors import KeyExists
from service.jobs.dispatch.leadership.leader import DispatcherLock
from service.jobs.store.sql.schema import NEWEST, bring_up_to_date, refuse_newer
from service.security.scopes import Scope

_TEXT = re.compile(r"wp_([0-9a-f]{12})_([A-Za-z0-9_-]{43})")
# No name looks like an id: both name a key for `revoke`.
_NAME = re.compile(r"(?![0-9a-f]{12}$)[A-Za-z0-9._-]{1,64}")
_NO_DIGEST = "0" * 64

_log = logging.getLogger(__name__)

metadata = MetaData()
api_keys = Table(
    "api_keys",
    metadata,
    Column("id", String(12), primary_key=True),
    Column("name", String(64), nullable=False, index=True),
    Column("digest", String(64), nullable=False),
    Column("scopes", String(80), nullable=False),
    Column("created_at", String(40), nullable=False),
    Column("expires_at", String(40), nullable=True),
    Column("revoked_at", String(40), nullable=True),
)


@dataclass(frozen=True)
class ApiKey:
    """What is kept of a key.

    Attributes:
        id: The part of it that is no secret.
        name: Whom or what it is for; several keys have one name while they are rotated.
        scopes: What it is good for.
        digest: sha256 of the secret, in hex.
        created_at: When it was made.
        expires_at: From when it is refused, None for never.
        revoked_at: When it was revoked, None if it was not.
    """

    id: str
    name: str
    scopes: frozenset[Scope]
    digest: str = field(repr=False)
    created_at: datetime
    expires_at: datetime | None = None
    revoked_at: datetime | None = None

    def is_valid(self, now: datetime) -> bool:
        """Return whether it is neither revoked nor expired."""
        return self.revoked_at is None and (self.expires_at is None or now < self.expires_at)

    def allows(self, scope: Scope) -> bool:
        """Return whether it is good for a scope; `admin` is for all of them."""
        return bool(self.scopes & {scope, Scope.ADMIN})


@dataclass(frozen=True)
class NewKey:
    """A key that was just made, and its text, which is not kept."""

    key: ApiKey
    text: str = field(repr=False)


def find_key(text: str, keys: dict[str, ApiKey]) -> ApiKey | None:
    """Return the key that a text is, whether valid or not; None if it is none.

    It takes as long for an unknown id as for a wrong secret.

    Args:
        text: As a client sends it.
        keys: By id.
    """
    parts = _TEXT.fullmatch(text)
    if parts is None:
        return None
    key = keys.get(parts[1])
    kept = _NO_DIGEST if key is None else key.digest
    return key if hmac.compare_digest(_digest(parts[2]), kept) else None


class KeyStore:
    """The keys in a database. It waits for the database: not for an event loop."""

    def __init__(self, engine: Engine) -> None:
        """Keep keys in `engine`; call `open` before use."""
        self._engine = engine
        self._told_of = set[str]()

    def open(self) -> None:
        """Bring the database to the newest revision; an older one only if no server works on it.

        Raises:
            DatabaseInUse: It has an older revision, and a server that knows no other.
            DatabaseTooNew: A newer version has changed it.
            DatabaseUnrecognized: Its tables are not this program's.
        """
        if refuse_newer(self._engine) != NEWEST:
            with DispatcherLock(self._engine).kept():
                bring_up_to_date(self._engine)

    def all(self) -> list[ApiKey]:
        """Return all keys, those that expired or were revoked too, oldest first."""
        query = select(api_keys).order_by(api_keys.c.created_at, api_keys.c.id)
        with self._engine.connect() as connection:
            found = [self._key_of(row) for row in connection.execute(query)]
        return [key for key in found if key is not None]

    def create(
        self,
        name: str,
        scopes: Iterable[Scope],
        now: datetime,
        expires_at: datetime | None = None,
    ) -> NewKey:
        """Make a key.

        Raises:
            ProblemInvalid: The name is none, or there is no scope.
            KeyExists: A valid key has the name.
        """
        chosen = frozenset(scopes)
        if _NAME.fullmatch(name) is None or not chosen:
            message = "a key has a name of 1 to 64 of A-Z a-z 0-9 . _ -, unlike an id"
            message += f", not {name[:80]!r}"
            fault = ("name", message) if chosen else ("scopes", f"the key {name!r} needs a scope")
            raise ProblemInvalid(fault[1], {"field": fault[0]})
        if self._valid(name, now):
            message = f"there is a key {name!r}; `wayproof keys rotate {name}` replaces it"
            raise KeyExists(message, {"name": name})
        return self._insert(name, chosen, now, expires_at)

    def revoke(self, name: str, now: datetime) -> list[ApiKey]:
        """Have all valid keys of a name, or the one of an id, refused from now on; return them.

        Raises:
            UnknownName: There is none.
        """
        found = self._known(name, now)
        change = update(api_keys).where(api_keys.c.id.in_([key.id for key in found]))
        with self._engine.begin() as connection:
            connection.execute(change.values(revoked_at=now.isoformat()))
        return found

    def rotate(self, name: str, now: datetime, overlap: timedelta) -> NewKey:
        """Make a key that takes the place of the valid ones of a name, with the same scopes.

        Args:
            name: Of the keys.
            now: What time it is.
            overlap: For which the old ones are still good.

        Raises:
            UnknownName: There is none.
        """
        old = self._known(name, now)
        last = old[-1]
        lifetime = None if last.expires_at is None else last.expires_at - last.created_at
        expires_at = None if lifetime is None else now + lifetime
        new = self._insert(last.name, last.scopes, now, expires_at)
        if not overlap:
            for key in old:
                self.revoke(key.id, now)
            return new
        with self._engine.begin() as connection:
            for key in old:
                until = min(now + overlap, key.expires_at or now + overlap)
                change = update(api_keys).where(api_keys.c.id == key.id)
                connection.execute(change.values(expires_at=until.isoformat()))
        return new

    def _key_of(self, row: Row[tuple[str, ...]]) -> ApiKey | None:
        """Return the key of a row, None for one that is wrong: it hides no other, nor a change."""
        try:
            return _key_of(row)
        except (TypeError, ValueError) as fault:
            if row.id not in self._told_of:
                self._told_of.add(row.id)
                _log.warning("a row of api_keys is no key: %s: %s", row.id, fault)
            return None

    def _insert(
        self, name: str, scopes: frozenset[Scope], now: datetime, expires_at: datetime | None
    ) -> NewKey:
        identifier, secret = secrets.token_hex(6), secrets.token_urlsafe(32)
        key = ApiKey(identifier, name, scopes, _digest(secret), now, expires_at)
        row = {
            "id": key.id,
            "name": name,
            "digest": key.digest,
            "scopes": ",".join(sorted(scopes)),
            "created_at": now.isoformat(),
            "expires_at": None if expires_at is None else expires_at.isoformat(),
        }
        with self._engine.begin() as connection:
            connection.execute(insert(api_keys).values(**row))
        return NewKey(key, f"wp_{identifier}_{secret}")

    def _valid(self, name: str, now: datetime) -> list[ApiKey]:
        return [key for key in self.all() if name in {key.name, key.id} and key.is_valid(now)]

    def _known(self, name: str, now: datetime) -> list[ApiKey]:
        found = self._valid(name, now)
        if not found:
            known = {key.name for key in self.all() if key.is_valid(now)}
            raise UnknownName.among("key", name[:80], known)
        return found


def _digest(secret: str) -> str:
    return hashlib.sha256(secret.encode("ascii")).hexdigest()


def _key_of(row: Row[tuple[str, ...]]) -> ApiKey:
    return ApiKey(
        id=row.id,
        name=row.name,
        scopes=frozenset(Scope(name) for name in row.scopes.split(",")),
        digest=row.digest,
        created_at=datetime.fromisoformat(row.created_at),
        expires_at=None if row.expires_at is None else datetime.fromisoformat(row.expires_at),
        revoked_at=None if row.revoked_at is None else datetime.fromisoformat(row.revoked_at),
    )
