"""Revisions of the tables of the records, run by alembic at start."""

HEAD = "0002"  #: the newest revision
