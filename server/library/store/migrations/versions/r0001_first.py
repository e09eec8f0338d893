"""The first tables: a database has them from its first opening, so that there is nothing to change."""

from __future__ import annotations

revision = "0001"
down_revision = None
