"""SceneRecord and its parts, and the tables that they are kept in."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
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

from service.jobs.store.sql.json_column import JsonText
from service.scenes.live import (
    JointPositions,
    KeptState,
    Motion,
    RobotState,
    described_positions,
    live_states,
    posed,
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

# Where robots are, as far as it is not what the latest revision says; see `live`.
scene_states = Table(
    "scene_states",
    metadata,
    Column("scene", String(64), primary_key=True),
    Column("robot", String(256), primary_key=True),
    Column("positions", JsonText, nullable=False),
    Column("status", String(12), nullable=False),
    # That set it by hand; null where an execution has measured it.
    Column("revision", Integer, nullable=True),
    # The last one whose end is known of. Sequences of jobs that are deleted are used again.
    Column("execution", String(64), nullable=True),
    Column("updated_at", String(40), nullable=False),
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
        live: Where its robots are, by name; nothing of a revision as it is described.
        moved: Where they are, by robot and joint, of those that are not where it has them.
    """

    loaded: LoadedScene
    unchecked_in: int | None = None
    live: Mapping[str, RobotState] = field(default_factory=dict)
    moved: Mapping[str, JointPositions] = field(default_factory=dict)

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

    def at(self, kept: Sequence[KeptState], motions: Sequence[Motion]) -> "SceneRecord":
        """Return the latest revision with its robots where they are.

        Args:
            kept: What is stored of them.
            motions: Executions that have not ended.
        """
        groups = self.summary.groups
        described = described_positions(groups)
        live = live_states(described, (self.revision, self.created_at), kept, motions)
        moved = {
            robot: state.positions
            for robot, state in live.items()
            if state.positions != described[robot]
        }
        loaded = self.loaded
        if moved:
            summary = self.summary.model_copy(update={"groups": posed(groups, moved)})
            loaded = loaded.model_copy(update={"summary": summary})
        return replace(self, loaded=loaded, live=live, moved=moved)

    @property
    def num_chars(self) -> int:
        """How much text it is, nearly."""
        names = len(self.summary.bodies) + len(self.summary.frames)
        return len(self.loaded.document.text) + len(self.loaded.unchecked.text) + 100 * names
