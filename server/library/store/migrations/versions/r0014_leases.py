"""Leases of jobs, and the ends of sign-ins, for several services on one database."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0014"
down_revision = "0013"


def upgrade() -> None:
    """Make the tables."""
    op.create_table(
        "leases",
        sa.Column("name", sa.String(200), primary_key=True),
        sa.Column("holder", sa.String(64), nullable=False),
        sa.Column("until_s", sa.Double, nullable=False),
        sa.Column("fraction", sa.Double, nullable=False),
    )
    op.create_table(
        "ended_sign_ins",
        sa.Column("name", sa.String(64), primary_key=True),
        sa.Column("given_s", sa.BigInteger, nullable=False),
    )
