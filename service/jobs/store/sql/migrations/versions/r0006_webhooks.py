"""Webhooks, and what they are still to be told."""

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"


def upgrade() -> None:
    """Make the tables."""
    serial = sa.BigInteger().with_variant(sa.Integer, "sqlite")
    op.create_table(
        "webhooks",
        sa.Column("sequence", serial, primary_key=True),
        sa.Column("id", sa.String(64), nullable=False, unique=True),
        sa.Column("url", sa.Text, nullable=False),
        sa.Column("secret", sa.String(100), nullable=False),
        sa.Column("events", sa.Text, nullable=False),
        sa.Column("created_at", sa.String(40), nullable=False),
        sa.Column("failing_since", sa.String(40), nullable=True),
        sa.Column("disabled_at", sa.String(40), nullable=True),
        sa.Column("reason", sa.String(200), nullable=False),
    )
    op.create_table(
        "webhook_notices",
        sa.Column("sequence", serial, primary_key=True),
        sa.Column("webhook", sa.String(64), nullable=False),
        sa.Column("job", sa.String(64), nullable=False),
        sa.Column("number", sa.Integer, nullable=False),
        sa.Column("attempts", sa.Integer, nullable=False),
        sa.Column("due_at", sa.String(40), nullable=False),
    )
    op.create_index("webhook_notices_of_job", "webhook_notices", ["webhook", "job", "sequence"])
    op.create_index("webhook_notices_by_time", "webhook_notices", ["due_at"])
