"""Options by which the scans of SLAM jobs were cut out of clouds and depth images."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0009"


def upgrade() -> None:
    """Add the column; of older jobs it is empty: cut as by default."""
    op.add_column("slam_jobs", sa.Column("cut", sa.Text))
