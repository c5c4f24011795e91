"""SceneRecord, and the table that it is kept in."""

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

metadata = MetaData()

# `serial` orders pages; SQLite counts by itself only in INTEGER primary keys.
scenes = Table(
    "scenes",
    metadata,
    Column("serial", BigInteger().with_variant(Integer, "sqlite"), primary_key=True),
    Column("id", String(64), nullable=False, index=True),
    Column("revision", Integer, nullable=False),
    Column("digest", String(64), nullable=False),
    Column("name", String(256), nullable=False),
    Column("created_at", String(40), nullable=False),
    Column("document", JSON, nullable=False),
    Column("summary", JSON, nullable=False),
    UniqueConstraint("id", "revision"),
    Index("scenes_by_revision", "revision", "serial"),
)


@dataclass(frozen=True)
class SceneRecord:
    """A revision of a scene.

    Attributes:
        serial: Order of creation.
        id: Of the scene.
        revision: From 1.
        digest: sha256 of the content, the bytes of all files included.
        name: For people.
        created_at: When (UTC).
        document: What was posted, or what came of editing it, defaults filled in.
        summary: What it holds once loaded, for the wire.
    """

    serial: int
    id: str
    revision: int
    digest: str
    name: str
    created_at: datetime
    document: dict[str, Any]
    summary: dict[str, Any]
