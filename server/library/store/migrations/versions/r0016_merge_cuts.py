"""Options by which the scans of merge jobs were cut out of clouds and depth images."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0016"
down_revision = "0015"


def upgrade() -> None:
    """Add the columns; of older jobs they are empty: cut as by default."""
    op.add_column("merge_jobs", sa.Column("cut", sa.Text))
    op.add_column("merge_jobs", sa.Column("other_cut", sa.Text))
