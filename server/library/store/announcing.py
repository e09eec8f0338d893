"""Triggers by which PostgreSQL notifies every service that uses a database of changes by another one.

Each change of a row is announced on :data:`CHANNEL` as ``TABLE KEY`` when its transaction is committed (NOTIFY).
"""

from __future__ import annotations

from sqlalchemy import Connection, text

CHANNEL = "gridbloom_changes"
#: Data that a service keeps in memory, and the announced column.
ANNOUNCED = {
    "logs": "id",
    "links": "log_id",
    "puzzles": "token",
    "trajectories": "log_id",
    "log_tags": "log_id",
    "jobs": "log_id",
    "ended_sign_ins": "name",
}
_TRIGGER = "gridbloom_announce"
_FUNCTION = f"""
CREATE OR REPLACE FUNCTION {_TRIGGER}() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  PERFORM pg_notify('{CHANNEL}', TG_TABLE_NAME || ' ' ||
    ((CASE TG_OP WHEN 'DELETE' THEN to_jsonb(OLD) ELSE to_jsonb(NEW) END) ->> TG_ARGV[0]));
  RETURN NULL;
END $$
"""


def announce_changes(connection: Connection) -> None:
    """Create missing triggers. All changes of a transaction are announced, equal ones once."""
    connection.execute(text(_FUNCTION))
    trigger = connection.execute(text("SELECT tgrelid::regclass::text FROM pg_trigger WHERE tgname = :name"),
                               {"name": _TRIGGER}).scalars()  # fmt: skip
    for table in ANNOUNCED.keys() - set(trigger):
        connection.exec_driver_sql(
            f"CREATE TRIGGER {_TRIGGER} AFTER INSERT OR UPDATE OR DELETE ON {table} "
            f"FOR EACH ROW EXECUTE FUNCTION {_TRIGGER}('{ANNOUNCED[table]}')"
        )
