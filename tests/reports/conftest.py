"""The command, run in this process."""

from tests.server.cli.conftest import run

__all__ = ["run"]
