"""The store of logs that the records belong to."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    """Make the table."""
    op.create_table("store", sa.Column("id", sa.String(64), primary_key=True))
