"""The tables of the records in the newest revision."""

from __future__ import annotations

from sqlalchemy import (
    BigInteger,
    Boolean,
    Column,
    Double,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    PrimaryKeyConstraint,
    String,
    Table,
    Text,
)

metadata = MetaData()

#: One row for each uploaded log, and for each log of the folder with known contents.
logs = Table(
    "logs",
    metadata,
    Column("id", String(64), primary_key=True),
    Column("owner", String(64), nullable=False),
    Column("name", Text, nullable=False),
    Column("source", String(16), nullable=False),
    Column("state", String(16), nullable=False),
    Column("bytes", BigInteger, nullable=False),
    Column("sha256", String(64), nullable=False),
    Column("created_s", Double, nullable=False),
    Column("used_s", Double, nullable=False),
    Column("error_code", String(64)),
    Column("error_message", Text),
    Column("summary", Text),  # JSON; PostgreSQL's own type rejects infinite values
    Column("attempts", Integer, nullable=False, server_default="0"),
    Index("logs_by_owner", "owner"),
    Index("logs_by_sha256", "sha256"),
)

#: One row for each unrevoked link to a view of a log. It is deleted with its log.
links = Table(
    "links",
    metadata,
    Column("token", String(64), primary_key=True),
    Column("owner", String(64), nullable=False),
    Column("log_id", String(64), ForeignKey("logs.id", ondelete="CASCADE"), nullable=False),
    Column("created_s", Double, nullable=False),
    Column("view", Text, nullable=False),  # JSON
    Index("links_by_log_id", "log_id"),
)

#: One row for each trajectory that a visitor has added to a log. It is deleted with its log.
trajectories = Table(
    "trajectories",
    metadata,
    Column("id", String(64), primary_key=True),
    Column("owner", String(64), nullable=False),
    Column("log_id", String(64), ForeignKey("logs.id", ondelete="CASCADE"), nullable=False),
    Column("name", Text, nullable=False),
    Column("description", Text, nullable=False),
    Column("source", String(16), nullable=False),
    Column("created_s", Double, nullable=False),
    Column("bytes", BigInteger, nullable=False),
    Column("poses", Integer, nullable=False),
    Column("length_m", Double, nullable=False),
    Column("has_graph", Boolean, nullable=False),
    Index("trajectories_by_log_id", "log_id"),
)

#: One row for each tag that a visitor has given to a log. It is deleted with its log.
log_tags = Table(
    "log_tags",
    metadata,
    Column("log_id", String(64), ForeignKey("logs.id", ondelete="CASCADE"), primary_key=True),
    Column("owner", String(64), primary_key=True),
    Column("tag", String(40), primary_key=True),
)

#: One row for each note on a log. It is deleted with its log.
notes = Table(
    "notes",
    metadata,
    Column("id", String(64), primary_key=True),
    Column("author", String(64), nullable=False),
    Column("log_id", String(64), ForeignKey("logs.id", ondelete="CASCADE"), nullable=False),
    Column("created_s", Double, nullable=False),
    Column("changed_s", Double, nullable=False),
    Column("text", Text, nullable=False),
    Column("at_s", Double),
    Column("scan", Integer),
    Column("x", Double),
    Column("y", Double),
    Column("outline", Text),  # JSON
    Index("notes_by_log_id", "log_id"),
)


#: One row for the newest job of each kind of each visitor on a log, and its result. It is deleted with its log. For a
#: job that maps a log as one of many, the owner is that of the log, empty for those of the folder.
jobs = Table(
    "jobs",
    metadata,
    Column("kind", String(32), primary_key=True),
    Column("log_id", String(64), ForeignKey("logs.id", ondelete="CASCADE"), primary_key=True),
    Column("owner", String(64), primary_key=True),
    Column("state", String(16), nullable=False),
    Column("created_s", Double, nullable=False),
    Column("attempts", Integer, nullable=False),
    Column("error_code", String(64)),
    Column("error_message", Text),
    Column("request", Text, nullable=False),  # JSON
    Column("result", Text),  # JSON
)

#: One row for each visitor's puzzle. That of a log is deleted with it.
puzzles = Table(
    "puzzles",
    metadata,
    Column("token", String(64), primary_key=True),
    Column("owner", String(64), nullable=False),
    Column("log_id", String(64), ForeignKey("logs.id", ondelete="CASCADE")),
    Column("created_s", Double, nullable=False),
    Column("title", Text, nullable=False),
    Column("spec", Text, nullable=False),  # JSON
    Index("puzzles_by_log_id", "log_id"),
)

#: One row: the id of the store of logs to which the records belong.
store = Table("store", metadata, Column("id", String(64), primary_key=True))

#: One row for each job that one of several services is doing: its holder, the expiry time without a renewal (seconds
#: since 1970, of the database's clock), and its completed share. The name identifies the job.
leases = Table(
    "leases",
    metadata,
    Column("name", String(200), primary_key=True),
    Column("holder", String(64), nullable=False),
    Column("until_s", Double, nullable=False),
    Column("fraction", Double, nullable=False),
)

#: One row for each sign-in that ended early, with the time at which it was created; ``*``: all up to that time.
ended_sign_ins = Table(
    "ended_sign_ins",
    metadata,
    Column("name", String(64), primary_key=True),
    Column("given_s", BigInteger, nullable=False),
)

#: One row: the newest revision that was run. alembic also creates and uses this table.
alembic_version = Table(
    "alembic_version",
    MetaData(),
    Column("version_num", String(32), nullable=False),
    PrimaryKeyConstraint("version_num", name="alembic_version_pkc"),
)
