"""Words by which visitors sort their logs."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"


def upgrade() -> None:
    """Make the table."""
    op.create_table(
        "log_tags",
        sa.Column("log_id", sa.String(64), sa.ForeignKey("logs.id", ondelete="CASCADE"), primary_key=True),
        sa.Column("owner", sa.String(64), primary_key=True),
        sa.Column("tag", sa.String(40), primary_key=True),
    )
