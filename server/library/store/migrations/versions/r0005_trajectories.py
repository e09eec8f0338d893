"""Trajectories that visitors add to logs."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"


def upgrade() -> None:
    """Make the table."""
    op.create_table(
        "trajectories",
        sa.Column("id", sa.String(64), primary_key=True),
        sa.Column("owner", sa.String(64), nullable=False),
        sa.Column("log_id", sa.String(64), sa.ForeignKey("logs.id", ondelete="CASCADE"), nullable=False),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("description", sa.Text, nullable=False),
        sa.Column("source", sa.String(16), nullable=False),
        sa.Column("created_s", sa.Double, nullable=False),
        sa.Column("bytes", sa.BigInteger, nullable=False),
        sa.Column("poses", sa.Integer, nullable=False),
        sa.Column("length_m", sa.Double, nullable=False),
        sa.Column("has_graph", sa.Boolean, nullable=False),
    )
    op.create_index("trajectories_by_log_id", "trajectories", ["log_id"])
