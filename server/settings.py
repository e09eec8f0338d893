"""The service's settings: read from the environment as GRIDBLOOM_*, each with the sentence that documents it."""

from __future__ import annotations

import ipaddress
import os
import re
import secrets
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, SecretStr, field_validator, model_validator
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict


def _default_data_dir() -> Path:
    """Return the folder that the XDG base directory specification gives an application for its data."""
    home = os.environ.get("XDG_DATA_HOME", "")
    return (Path(home) if home.startswith("/") else Path.home() / ".local" / "share") / "gridbloom"


class Settings(BaseSettings):
    """Every setting once; ``GRIDBLOOM_PORT=9000`` in the environment sets ``port``."""

    model_config = SettingsConfigDict(env_prefix="GRIDBLOOM_", frozen=True, extra="forbid")

    host: str = Field(
        default="127.0.0.1", description="Address to listen on; any other than loopback asks for a token."
    )
    port: int = Field(default=8000, ge=0, le=65535, description="Port to listen on; 0 takes a free one.")
    token: SecretStr | None = Field(
        default=None,
        description="Secret that visitors must know; made at start where the service is reached from beyond loopback.",
    )
    no_token: bool = Field(
        default=False, description="Ask for no token although the service is reached from beyond loopback."
    )
    allowed_hosts: Annotated[tuple[str, ...], NoDecode] = Field(
        default=(),
        description="Names, separated by commas, under which browsers may reach the service besides its own address, "
        "as behind a reverse proxy; * allows every name. Any name beyond loopback asks for a token.",
    )
    data_dir: Path = Field(default_factory=_default_data_dir, description="Folder for uploaded logs and their records.")
    blobs: str | None = Field(
        default=None,
        description="Where the bytes of uploaded logs are kept: a folder, or s3://BUCKET/PREFIX with AWS_… in the "
        "environment; by default the data folder.",
    )
    database: SecretStr | None = Field(
        default=None,
        description="Database of the records: sqlite:///FILE or postgresql://…; by default a file in the data folder.",
    )
    executor: str | None = Field(
        default=None,
        pattern=r"^tcp://[^/]+:[0-9]+$",
        description="Where logs are read: by default a process of this machine; tcp://HOST:PORT is a Dask scheduler "
        "whose workers see the data folder by the same path.",
    )
    logs_dir: Path | None = Field(default=None, description="Folder whose logs everybody sees, read-only.")
    max_sessions: int = Field(default=64, ge=1, description="Live sessions at one time.")
    max_sessions_per_visitor: int = Field(default=8, ge=1, description="Live sessions of one browser at one time.")
    max_clients_per_session: int = Field(default=64, ge=1, description="Browsers that watch one session at one time.")
    session_idle_s: float = Field(
        default=900.0, gt=0.0, description="Seconds after which a session that nobody watches is ended."
    )
    max_cells: int = Field(default=1 << 25, ge=1 << 12, description="Cells of one session's grid.")
    max_total_cells: int = Field(default=1 << 27, ge=1 << 12, description="Cells of all sessions' grids together.")
    max_log_bytes: int = Field(
        default=4 << 30, ge=1 << 20, description="Bytes in memory of the logs of all sessions together."
    )
    max_story_s: float = Field(
        default=30.0,
        gt=0.0,
        description="Seconds of computing, as estimated, that replaying a live world from a link may take.",
    )
    max_upload_bytes: int = Field(default=1 << 30, ge=1, description="Bytes of one uploaded log.")
    max_connections: int = Field(
        default=4096, ge=1, description="Open connections at one time; the limit of descriptors may allow fewer."
    )
    max_connections_per_address: int = Field(
        default=1024,
        ge=1,
        description="Open connections of one address at one time; a reverse proxy's address is that of all visitors.",
    )
    header_timeout_s: float = Field(
        default=10.0, gt=0.0, description="Seconds in which the headers of a request must come whole."
    )
    threads: int = Field(
        default_factory=lambda: max(2, min(8, os.cpu_count() or 2)), ge=1, description="Threads that compute maps."
    )
    log_format: Literal["console", "json"] = Field(default="console", description="How log lines are written.")
    log_level: Literal["debug", "info", "warning", "error"] = Field(
        default="info", description="The least that is logged."
    )

    @field_validator("allowed_hosts", mode="before")
    @classmethod
    def _split(cls, value: object) -> object:
        return tuple(name.strip() for name in value.split(",") if name.strip()) if isinstance(value, str) else value

    @field_validator("blobs")
    @classmethod
    def _some_store(cls, value: str | None) -> str | None:
        if value is None:
            return None
        if value.startswith("s3://"):
            if not re.fullmatch(r"s3://[a-z0-9][a-z0-9.-]{2,62}(/[^?#]*)?", value):
                raise ValueError("a bucket is named as s3://BUCKET/PREFIX")
        elif "://" in value or not value:
            raise ValueError("it is a folder, or begins with s3://")
        return value

    @field_validator("database")
    @classmethod
    def _some_database(cls, value: SecretStr | None) -> SecretStr | None:
        if value is not None and not value.get_secret_value().startswith(("sqlite:///", "postgresql://")):
            raise ValueError("it begins with sqlite:/// or postgresql://")
        return value

    @field_validator("token")
    @classmethod
    def _some_token(cls, value: SecretStr | None) -> SecretStr | None:
        if value is not None and len(value.get_secret_value()) < 8:
            raise ValueError("a token has at least 8 characters")
        return value

    @model_validator(mode="after")
    def _one_wish(self) -> Settings:
        if self.no_token and self.token is not None:
            raise ValueError("a token and no_token contradict each other")
        return self

    @property
    def database_url(self) -> str | None:
        """The database's address, with its password; None for the usual file."""
        return None if self.database is None else self.database.get_secret_value()

    @property
    def is_loopback(self) -> bool:
        """Whether the service listens on this machine's loopback address only."""
        return _is_loopback(self.host)

    @property
    def is_reached_from_beyond(self) -> bool:
        """Whether others than this machine may reach the service, by its address or through a reverse proxy."""
        return not (self.is_loopback and all(map(_is_loopback, self.allowed_hosts)))

    def with_token(self) -> Settings:
        """Return settings that have a token where one is needed: the given one, or a new one."""
        if self.token is not None or self.no_token or not self.is_reached_from_beyond:
            return self
        return self.model_copy(update={"token": SecretStr(secrets.token_urlsafe(24))})


def _is_loopback(host: str) -> bool:
    """Whether a name or an address is this machine's own, without looking it up."""
    name = host.strip("[]").lower()
    if name == "localhost" or name.endswith(".localhost"):
        return True
    try:
        return ipaddress.ip_address(name).is_loopback
    except ValueError:
        return False
