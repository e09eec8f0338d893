"""Notes on areas: the corners of a polygon, as JSON."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    """Add the column."""
    op.add_column("notes", sa.Column("outline", sa.Text))
