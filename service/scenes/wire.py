"""Scene records to the wire."""

from typing import Any

from service.scenes.records import SceneRecord


def scene_brief(record: SceneRecord) -> dict[str, Any]:
    """Return a scene without its content."""
    return {
        "id": record.id,
        "revision": record.revision,
        "digest": record.digest,
        "name": record.name,
        "created_at": record.created_at,
    }


def scene_resource(record: SceneRecord) -> dict[str, Any]:
    """Return a scene in full."""
    return {**record.summary, **scene_brief(record), "document": record.document}
