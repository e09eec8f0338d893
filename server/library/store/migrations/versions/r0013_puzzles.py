"""Puzzles that visitors make."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0013"
down_revision = "0012"


def upgrade() -> None:
    """Make the table."""
    op.create_table(
        "puzzles",
        sa.Column("token", sa.String(64), primary_key=True),
        sa.Column("owner", sa.String(64), nullable=False),
        sa.Column("log_id", sa.String(64), sa.ForeignKey("logs.id", ondelete="CASCADE")),
        sa.Column("created_s", sa.Double, nullable=False),
        sa.Column("title", sa.Text, nullable=False),
        sa.Column("spec", sa.Text, nullable=False),
    )
    op.create_index("puzzles_by_log_id", "puzzles", ["log_id"])
