"""Jobs may be of a batch, and say when their end was requested; scenes may be posted with a key.

Requests of plans say `ik.allowed_time` where they said `ik.time_limit`.
"""

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"


def upgrade() -> None:
    """Add columns; jobs whose end was requested before have no instant of that."""
    op.add_column("jobs", sa.Column("cancel_requested_at", sa.String(40), nullable=True))
    op.add_column("jobs", sa.Column("batch", sa.String(64), nullable=True))
    op.create_index("jobs_of_batch", "jobs", ["batch", "sequence"])
    op.add_column("scenes", sa.Column("key", sa.String(200), nullable=True))
    op.add_column("scenes", sa.Column("request_digest", sa.String(64), nullable=True))
    op.create_index("scenes_by_key", "scenes", ["key"], unique=True)
    # In a text of JSON a quotation mark that ends no string is escaped: this is a key.
    former, key = '"time_limit":', '"allowed_time":'
    for name in ("job_bodies", "job_summaries"):
        table = sa.table(name, sa.column("payload", sa.Text))
        renamed = sa.func.replace(table.c.payload, former, key)
        has_it = table.c.payload.contains(former)
        op.execute(sa.update(table).where(has_it).values(payload=renamed))
