"""The first tables of a release: a database has them from its first opening, so that there is nothing to change."""

from __future__ import annotations

revision = "0002"
down_revision = None
