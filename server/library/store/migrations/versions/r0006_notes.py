"""Notes that visitors pin to a time or a place of a log."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"


def upgrade() -> None:
    """Make the table."""
    op.create_table(
        "notes",
        sa.Column("id", sa.String(64), primary_key=True),
        sa.Column("author", sa.String(64), nullable=False),
        sa.Column("log_id", sa.String(64), sa.ForeignKey("logs.id", ondelete="CASCADE"), nullable=False),
        sa.Column("created_s", sa.Double, nullable=False),
        sa.Column("changed_s", sa.Double, nullable=False),
        sa.Column("text", sa.Text, nullable=False),
        sa.Column("at_s", sa.Double),
        sa.Column("scan", sa.Integer),
        sa.Column("x", sa.Double),
        sa.Column("y", sa.Double),
    )
    op.create_index("notes_by_log_id", "notes", ["log_id"])
