"""The service's settings, read from the environment variables GRIDBLOOM_*, with their documentation."""

from __future__ import annotations

import difflib
import ipaddress
import os
import re
import secrets
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, SecretStr, field_validator, model_validator
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict

from server.network_address import is_loopback_name
from server.storage import RECORDS_FILE


def _default_data_dir() -> Path:
    """Return the folder for an application's data according to the XDG base directory specification."""
    home = os.environ.get("XDG_DATA_HOME", "")
    return (Path(home) if home.startswith("/") else Path.home() / ".local" / "share") / "gridbloom"


_PREFIX = "GRIDBLOOM_"
#: Variables with the prefix that are used by tests, benchmarks and the build of the pages.
_OF_TESTS = {
    f"{_PREFIX}{name}"
    for name in (
        *("CHROMIUM", "DEV_SERVER", "DRIVES", "EXAMPLES", "FAULTS", "FAULTS_SEED", "FUZZ", "LATE_MS", "OPEN3D"),
        *("PEERS", "SEED", "SEEDS", "SOAK_MIN", "TEST_DATA"),
    )
}


class Settings(BaseSettings):
    """The settings. ``GRIDBLOOM_PORT=9000`` in the environment sets ``port``."""

    model_config = SettingsConfigDict(env_prefix=_PREFIX, frozen=True, extra="forbid")

    host: str = Field(
        default="127.0.0.1", description="Address to listen on. On any other than loopback a token is required."
    )
    port: int = Field(default=8000, ge=0, le=65535, description="Port to listen on; 0 chooses a free one.")
    token: SecretStr | None = Field(
        default=None,
        description="Secret that visitors must know. Generated at start if it is not given and other machines can "
        "reach the service.",
    )
    no_token: bool = Field(default=False, description="Require no token although other machines can reach the service.")
    allowed_hosts: Annotated[tuple[str, ...], NoDecode] = Field(
        default=(),
        description="Host names, separated by commas, that browsers may use besides the service's own address, "
        "for example behind a reverse proxy; * allows every name. With any name beyond loopback a token is required.",
    )
    trusted_proxies: Annotated[tuple[str, ...], NoDecode] = Field(
        default=("127.0.0.1", "::1"),
        description="Addresses or networks of reverse proxies, separated by commas, whose X-Forwarded-For and "
        "X-Forwarded-Proto name the client: limits per address then hold for it, not for the proxy.",
    )
    data_dir: Path = Field(default_factory=_default_data_dir, description="Folder for uploaded logs and their records.")
    blobs: str | None = Field(
        default=None,
        description="Store of the files of uploaded logs: a folder, or s3://BUCKET/PREFIX with AWS_… in the "
        "environment; by default the data folder.",
    )
    database: SecretStr | None = Field(
        default=None,
        description="Database of the records: sqlite:///FILE or postgresql://…; by default a file in the data folder.",
    )
    executor: str | None = Field(
        default=None,
        pattern=r"^(tcp|tls)://[^/]+:[0-9]+$",
        description="Where logs are read: by default in a process of this machine; tcp://HOST:PORT or tls://HOST:PORT "
        "is a Dask scheduler whose workers access the data folder at the same path.",
    )
    fleet_executor: str | None = Field(
        default=None,
        pattern=r"^(tcp|tls)://[^/]+:[0-9]+$",
        description="Where the page /fleet.html has logs mapped: by default in processes of this machine; "
        "tcp://HOST:PORT or tls://HOST:PORT is a Dask scheduler, to whose workers the logs are sent.",
    )
    fleet_workers: int = Field(
        default_factory=lambda: max(1, (os.cpu_count() or 2) - 1),
        ge=1,
        description="Number of logs that are read, examined and mapped at once by the page /fleet.html on this "
        "machine; a cluster does as many as its workers have threads.",
    )
    logs_dir: Path | None = Field(default=None, description="Folder of logs that all visitors see, read-only.")
    max_sessions: int = Field(default=64, ge=1, description="Maximum number of concurrent sessions.")
    max_sessions_per_visitor: int = Field(
        default=8, ge=1, description="Maximum number of concurrent sessions of one browser."
    )
    max_clients_per_session: int = Field(
        default=64, ge=1, description="Maximum number of browsers connected to one session."
    )
    max_class_followers: int = Field(
        default=400,
        ge=1,
        description="Maximum number of followers of one class that are connected at one time; from one address, such "
        "as a lecture hall's router, three quarters of it.",
    )
    class_code: str | None = Field(
        default=None,
        pattern=r"^[BCDFGHJKLMNPQRSTVWXZ]{6}$",
        description="Code of a class that is open from the start: six consonants.",
    )
    session_idle_s: float = Field(
        default=900.0, gt=0.0, description="Seconds after which a session without connected browsers is closed."
    )
    max_cells: int = Field(default=1 << 25, ge=1 << 12, description="Maximum number of cells of one session's grid.")
    max_total_cells: int = Field(
        default=1 << 27, ge=1 << 12, description="Maximum number of cells of all sessions' grids together."
    )
    max_log_bytes: int = Field(
        default=4 << 30, ge=1 << 20, description="Maximum memory of the logs of all sessions together, bytes."
    )
    max_story_s: float = Field(
        default=30.0,
        gt=0.0,
        description="Estimated computing time that replaying a world from a link may take, seconds.",
    )
    max_upload_bytes: int = Field(
        default=1 << 30,
        ge=1,
        description="Maximum size of one uploaded log, bytes. One visitor's logs have room for two of this size, all "
        "for four, if that is more than 10 and 20 GiB.",
    )
    max_connections: int = Field(
        default=4096,
        ge=1,
        description="Maximum number of open connections; the limit of file descriptors may allow fewer.",
    )
    max_connections_per_address: int = Field(
        default=1024,
        ge=1,
        description="Maximum number of open connections of one address. Behind a reverse proxy all visitors have its "
        "address.",
    )
    header_timeout_s: float = Field(
        default=10.0, gt=0.0, description="Seconds within which the headers of a request must be complete."
    )
    threads: int = Field(
        default_factory=lambda: max(2, min(8, os.cpu_count() or 2)),
        ge=1,
        description="Number of threads that compute maps.",
    )
    workers: int = Field(
        default=1,
        ge=1,
        le=256,
        description="Number of processes that have the sessions, behind the one port; auto: one for each core on a "
        "machine with more than two, else one. Linux only.",
    )
    compile_ahead: bool = Field(
        default=True,
        description="Whether a process of the lowest priority compiles all kernels after the start, where that was not "
        "done before; else each is compiled when it is first used.",
    )
    log_format: Literal["console", "json"] = Field(default="console", description="Format of log lines.")
    log_level: Literal["debug", "info", "warning", "error"] = Field(
        default="info", description="Lowest level that is logged."
    )

    @field_validator("workers", mode="before")
    @classmethod
    def _one_for_each_core(cls, value: object) -> object:
        if value != "auto":
            return value
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1
        return cores if cores > 2 else 1

    @field_validator("trusted_proxies")
    @classmethod
    def _networks(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        for item in value:
            try:
                ipaddress.ip_network(item, strict=False)
            except ValueError:
                raise ValueError(f"{item!r} is no IP address and no network such as 10.0.0.0/8") from None
        return value

    @field_validator("allowed_hosts", "trusted_proxies", mode="before")
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
        if self.workers > 1 and not sys.platform.startswith("linux"):
            raise ValueError("several workers need Linux")
        return self

    @property
    def database_url(self) -> str | None:
        """The database's URL, with its password; None for the default file."""
        return None if self.database is None else self.database.get_secret_value()

    def of_worker(self, worker: int) -> Settings:
        """Return the settings of one of several workers: shared records and blobs, and its own folder for the rest."""
        root = self.data_dir / "library"
        shared = {
            "database": self.database or SecretStr(f"sqlite:///{(root / RECORDS_FILE).absolute()}"),
            "blobs": self.blobs or str(root),
        }
        return self.model_copy(update={**shared, "data_dir": self.data_dir / "workers" / str(worker)})

    @property
    def is_loopback(self) -> bool:
        """Whether the service listens only on this machine's loopback address."""
        return is_loopback_name(self.host)

    @property
    def is_reached_from_beyond(self) -> bool:
        """Whether other machines may reach the service, by its address or through a reverse proxy."""
        return not (self.is_loopback and all(map(is_loopback_name, self.allowed_hosts)))

    def with_token(self) -> Settings:
        """Return settings with a token if one is required: the given one, or a new one."""
        if self.token is not None or self.no_token or not self.is_reached_from_beyond:
            return self
        return self.model_copy(update={"token": SecretStr(secrets.token_urlsafe(24))})


def unknown_setting(variables: Iterable[str]) -> str | None:
    """Return an error about the first environment variable that looks like a setting but is none."""
    names = [_PREFIX + name.upper() for name in Settings.model_fields]
    for variable in sorted(variables):
        name = variable.upper()  # as pydantic compares names
        if name.startswith(_PREFIX) and name not in names and name not in _OF_TESTS:
            meant = difflib.get_close_matches(name, names, n=1)
            return f"{variable} is no setting" + (f"; {meant[0]} is one." if meant else ".")
    return None
