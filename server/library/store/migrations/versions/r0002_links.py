"""Links that open a view of a log."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    """Make the table."""
    op.create_table(
        "links",
        sa.Column("token", sa.String(64), primary_key=True),
        sa.Column("owner", sa.String(64), nullable=False),
        sa.Column("log_id", sa.String(64), sa.ForeignKey("logs.id", ondelete="CASCADE"), nullable=False),
        sa.Column("created_s", sa.Double, nullable=False),
        sa.Column("view", sa.Text, nullable=False),
    )
    op.create_index("links_by_log_id", "links", ["log_id"])
