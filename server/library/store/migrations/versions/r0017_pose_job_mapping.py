"""Parameters of the map for which SLAM and localization find poses: its mount and its time offset are theirs."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0017"
down_revision = "0016"


def upgrade() -> None:
    """Add the columns; of older jobs they are empty: as by default."""
    op.add_column("slam_jobs", sa.Column("mapping", sa.Text))
    op.add_column("localization_jobs", sa.Column("mapping", sa.Text))
