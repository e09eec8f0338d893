"""The parameters of SLAM jobs that differ from the first values."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"


def upgrade() -> None:
    """Add the column; of older jobs it is empty."""
    op.add_column("slam_jobs", sa.Column("parameters", sa.Text))
