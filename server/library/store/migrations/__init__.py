"""Revisions of the tables of the records, run by alembic at start."""

HEAD = "0001"  #: the newest revision
