"""Number of times that the reading of a log was begun: a log that ends the service is not read without end."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"


def upgrade() -> None:
    """Add the column."""
    op.add_column("logs", sa.Column("attempts", sa.Integer, nullable=False, server_default="0"))
