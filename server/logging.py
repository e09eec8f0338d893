"""Structured logs: lines for people on a terminal, JSON for machines. No token, visitor or session id is logged."""

from __future__ import annotations

import hashlib
import logging
import re
import sys

import structlog
from structlog.dev import ConsoleRenderer, plain_traceback
from structlog.processors import JSONRenderer
from structlog.tracebacks import ExceptionDictTransformer
from structlog.typing import Processor

_LEVELS = {"debug": logging.DEBUG, "info": logging.INFO, "warning": logging.WARNING, "error": logging.ERROR}


#: These are followed by a secret in an address: a session's id or a link's token gives access.
_SECRET = re.compile(r"((?:/(?:sessions|scenes|shared)/|[?&](?:token|session)=))[A-Za-z0-9_~%.-]+")


def short_hash(secret: str) -> str:
    """Return the first 8 hexadecimal digits of the SHA-256 of ``secret``, which identify it in log lines."""
    return hashlib.sha256(secret.encode()).hexdigest()[:8]


def without_secrets(line: str) -> str:
    """Return a log line without tokens and the secrets in the addresses of sessions, 3D views and links."""
    return _SECRET.sub(r"\1…", line)


class _Formatter(structlog.stdlib.ProcessorFormatter):
    """Formats log lines, including tracebacks and those of libraries, without the secrets in addresses."""

    def format(self, record: logging.LogRecord) -> str:
        return without_secrets(super().format(record))


def configure_logging(log_format: str, level: str) -> None:
    """Send the service's and the libraries' log lines to standard error in one form.

    ``log_format`` is ``"console"`` or ``"json"``. uvicorn's access lines are off, because they contain addresses, and
    the token.
    """
    shared: list[Processor] = [
        structlog.contextvars.merge_contextvars,
        structlog.stdlib.add_log_level,
        structlog.stdlib.add_logger_name,
        structlog.processors.TimeStamper(fmt="iso", utc=True),
    ]
    structlog.configure(
        processors=[*shared, structlog.stdlib.ProcessorFormatter.wrap_for_formatter],
        wrapper_class=structlog.make_filtering_bound_logger(_LEVELS[level]),
        logger_factory=structlog.stdlib.LoggerFactory(),
        cache_logger_on_first_use=False,
    )
    # Tracebacks without the values of variables, which may include a token.
    last: list[Processor] = (
        [structlog.processors.ExceptionRenderer(ExceptionDictTransformer(show_locals=False)), JSONRenderer()]
        if log_format == "json"
        else [ConsoleRenderer(colors=sys.stderr.isatty(), exception_formatter=plain_traceback)]
    )
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(
        _Formatter(
            foreign_pre_chain=shared, processors=[structlog.stdlib.ProcessorFormatter.remove_processors_meta, *last]
        )
    )
    root = logging.getLogger()
    root.handlers = [handler]
    root.setLevel(_LEVELS[level])
    # "connection open" and the address of each socket, which the service logs itself.
    for name in ("uvicorn.error", "httpx", "numba", "websockets"):
        logging.getLogger(name).setLevel(max(_LEVELS[level], logging.WARNING))
    logging.getLogger("uvicorn.error").addFilter(_is_ours)


def _is_ours(record: logging.LogRecord) -> bool:
    """Return False for the traceback that uvicorn logs when a client sends text that is not valid UTF-8."""
    return not record.getMessage().startswith("Invalid UTF-8 sequence")
