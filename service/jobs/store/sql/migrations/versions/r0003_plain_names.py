"""Columns and tables are called as the code calls what they hold."""

from alembic import op

revision = "0003"
down_revision = "0002"

_COLUMNS = {
    "serial": "sequence",
    "lane": "queue",
    "warm_key": "world_digest",
    "allowed": "time_limit",
}


def upgrade() -> None:
    """Rename them; indices follow, but for one that has a former name itself."""
    for former, name in _COLUMNS.items():
        op.alter_column("jobs", former, new_column_name=name)
    op.rename_table("job_briefs", "job_summaries")
    op.drop_index("jobs_of_lane", "jobs")
    op.create_index("jobs_of_queue", "jobs", ["queue", "sequence"])
