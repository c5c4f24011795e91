"""Rows of the table of live states: what is read and written in a connection."""

from collections.abc import Iterable, Mapping
from datetime import datetime
from typing import Any

from sqlalchemy import Connection, delete, insert, select

from service.jobs.store.sql.tables import scene_entries
from service.scenes.live import (
    EditSource,
    ExecutionSource,
    JointPositions,
    KeptState,
    RobotState,
    RobotStatus,
    Source,
)
from service.scenes.store.records import scene_states
from service.scenes.store.rows import latest_revision, lock


def read_states(connection: Connection, scene: str) -> list[KeptState]:
    """Return what is stored of the robots of a scene."""
    query = select(scene_states).where(scene_states.c.scene == scene)
    return [_state(row) for row in connection.execute(query).mappings()]


def write_placed(
    connection: Connection,
    scene: str,
    robots: Iterable[str],
    before: Mapping[str, RobotState],
    revision: tuple[int, datetime],
) -> None:
    """Note that robots were set by hand; what was measured before is no more.

    Args:
        connection: In the transaction that adds the revision.
        scene: Its id.
        robots: That were set.
        before: Where they were.
        revision: What came of it, and when (UTC).
    """
    number, at = revision
    for robot in robots:
        ended = before[robot].ended if robot in before else None
        state = KeptState(robot, {}, RobotStatus.AT_REST, EditSource(number), at, ended)
        _write(connection, scene, state)


def write_measured(
    connection: Connection,
    scene: str,
    positions: Mapping[str, JointPositions],
    status: RobotStatus,
    execution: str,
    at: datetime,
) -> None:
    """Keep what an execution has measured, unless the scene is gone.

    Args:
        connection: In the transaction that ends it.
        scene: Its id.
        positions: By robot and joint.
        status: Of the robots, after it.
        execution: Its id.
        at: When it ended (UTC).
    """
    lock(connection, scene)
    if latest_revision(connection, scene) is None:
        return
    known = {state.robot: state for state in read_states(connection, scene)}
    for robot, joints in positions.items():
        before = known.get(robot)
        measured = {**(before.positions if before else {}), **joints}
        source = ExecutionSource(execution)
        _write(connection, scene, KeptState(robot, measured, status, source, at, execution))


def delete_states(connection: Connection, scene: str) -> None:
    """Forget the robots of a scene, and what has moved them."""
    connection.execute(delete(scene_entries).where(scene_entries.c.scene == scene))
    connection.execute(delete(scene_states).where(scene_states.c.scene == scene))


def _write(connection: Connection, scene: str, state: KeptState) -> None:
    where = (scene_states.c.scene == scene) & (scene_states.c.robot == state.robot)
    connection.execute(delete(scene_states).where(where))
    connection.execute(insert(scene_states).values(scene=scene, **_columns(state)))


def _columns(state: KeptState) -> dict[str, Any]:
    return {
        "robot": state.robot,
        "positions": dict(state.positions),
        "status": state.status.value,
        "revision": None if isinstance(state.source, ExecutionSource) else state.source.revision,
        "execution": state.ended,
        "updated_at": state.updated_at.isoformat(),
    }


def _state(row: Mapping[Any, Any]) -> KeptState:
    return KeptState(
        robot=row["robot"],
        positions=row["positions"],
        status=RobotStatus(row["status"]),
        source=_source(row),
        updated_at=datetime.fromisoformat(row["updated_at"]),
        ended=row["execution"],
    )


def _source(row: Mapping[Any, Any]) -> Source:
    revision = row["revision"]
    return ExecutionSource(row["execution"]) if revision is None else EditSource(revision)
