"""The first tables of a release. A database has them from its first opening, so that nothing changes."""

from __future__ import annotations

revision = "0002"
down_revision = None
