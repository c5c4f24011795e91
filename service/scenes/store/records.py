"""SceneRecord and its parts, and the table that they are kept in."""

import json
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from sqlalchemy import (
    JSON,
    BigInteger,
    Column,
    Index,
    Integer,
    MetaData,
    String,
    Table,
    UniqueConstraint,
)

from service.scenes.models.scene import SceneSummary
from service.scenes.tasks import LoadedScene

metadata = MetaData()

# `serial` orders pages; SQLite counts by itself only in INTEGER primary keys.
scenes = Table(
    "scenes",
    metadata,
    Column("serial", BigInteger().with_variant(Integer, "sqlite"), primary_key=True),
    Column("id", String(64), nullable=False, index=True),
    Column("revision", Integer, nullable=False),
    Column("digest", String(64), nullable=False),
    Column("artifact", String(64), nullable=False),
    Column("name", String(256), nullable=False),
    Column("created_at", String(40), nullable=False),
    Column("summary", JSON, nullable=False),
    # Of the request that posted it, in the row of the first revision alone.
    Column("key", String(200), nullable=True),
    Column("request_digest", String(64), nullable=True),
    UniqueConstraint("id", "revision"),
    Index("scenes_by_revision", "revision", "serial"),
    Index("scenes_by_key", "key", unique=True),
)


@dataclass(frozen=True)
class SceneBrief:
    """A revision of a scene without its content.

    Attributes:
        serial: Order of creation.
        id: Of the scene.
        revision: From 1.
        digest: sha256 of the content, the bytes of all files included.
        artifact: sha256 of the artifact that has its document and says what its files are.
        name: For people.
        created_at: When (UTC).
    """

    serial: int
    id: str
    revision: int
    digest: str
    artifact: str
    name: str
    created_at: datetime


@dataclass(frozen=True)
class SceneRecord(SceneBrief):
    """A revision of a scene.

    Attributes:
        loaded: Its content.
        unchecked_in: An earlier revision whose row has the pairs that are not looked at, which are
            the same in this one; None if its own row has them.
    """

    loaded: LoadedScene
    unchecked_in: int | None = None

    @property
    def document(self) -> dict[str, Any]:
        """What was posted, or what came of editing it; read each time: of many objects it is long.

        Answers and files take the text itself.
        """
        found: dict[str, Any] = json.loads(self.loaded.document.text)
        return found

    @property
    def summary(self) -> SceneSummary:
        """What it holds once loaded, but for the pairs that are not looked at."""
        return self.loaded.summary

    @property
    def num_chars(self) -> int:
        """How much text it is, nearly."""
        names = len(self.summary.bodies) + len(self.summary.frames)
        return len(self.loaded.document.text) + len(self.loaded.unchecked.text) + 100 * names
