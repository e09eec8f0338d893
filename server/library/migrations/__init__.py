"""How the tables of the records came to be as they are: one revision after the other, run by alembic at start."""

HEAD = "0016"  #: the newest revision
