"""Jobs know their client: clients take turns."""

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"


def upgrade() -> None:
    """Add it; of what is there already nothing is known."""
    client = sa.Column("client", sa.String(80), nullable=False, server_default="")
    op.add_column("jobs", client)
