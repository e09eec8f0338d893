"""Read a ROS parameter file: yaml with ``ros__parameters`` somewhere in it.

Source: the design articles of ROS 2, Parameter YAML files.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import yaml

from mapper.core.errors import LimitError, ReadError
from mapper.io.untrusted_yaml import AliasError, CountError, DepthError, UntrustedLoader, load_untrusted

MAX_BYTES = 1 << 20  #: a whole Nav2 stack's file has some 20 kB
MAX_DEPTH = UntrustedLoader.most_levels
MAX_VALUES = UntrustedLoader.most_values


def read_parameter_file(path: str | os.PathLike[str]) -> bytes:
    """Return the bytes of a parameter file, one more than it may have at most. Raises :class:`ReadError`."""
    place = Path(path)
    try:
        with place.open("rb") as file:
            return file.read(MAX_BYTES + 1)
    except OSError as error:
        message = f"The file {place.name!r} cannot be read: {error.strerror}."
        raise ReadError("parameters.unreadable", message) from error


def parse_ros_parameters(data: bytes) -> dict[str, Any]:
    """Return the mapping that a parameter file's bytes hold.

    Raises :class:`ReadError` for text that is not such a mapping and names the line where there is one, and
    :class:`LimitError` for more than 1 MiB or 10 000 values.
    """
    if len(data) > MAX_BYTES:
        raise LimitError("parameters.too_large", f"A parameter file may have {MAX_BYTES} bytes, not {len(data)}.")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        message = f"The parameter file is not UTF-8 text: byte {error.start} is wrong."
        raise ReadError("parameters.text", message) from error
    try:
        root = load_untrusted(text)
    except AliasError as error:
        raise ReadError("parameters.alias", "The parameter file has an alias, which is not read.") from error
    except DepthError as error:
        raise ReadError("parameters.depth", f"The parameter file is nested deeper than {MAX_DEPTH} levels.") from error
    except CountError as error:
        message = f"A parameter file may have {MAX_VALUES} keys, values and lists; this one has more."
        raise LimitError("parameters.too_many", message) from error
    except yaml.MarkedYAMLError as error:
        line = f" in line {error.problem_mark.line + 1}" if error.problem_mark else ""
        raise ReadError("parameters.yaml", f"The parameter file is malformed{line}: {error.problem}.") from error
    except yaml.YAMLError as error:
        raise ReadError("parameters.yaml", "The parameter file is malformed.") from error
    if not isinstance(root, dict):
        raise ReadError("parameters.yaml", "The parameter file holds no names with values.")
    return root


def find_node(root: dict[str, Any], names: tuple[str, ...]) -> tuple[str, dict[str, Any]] | None:
    """Return the parameters of the first node of ``names`` in a file's mapping, and its name.

    The ``ros__parameters`` may be below namespaces, in any depth. None where no such node is in the file.
    """
    for name in names:
        found = value_below(root, name)
        while isinstance(found, dict):
            inner = found.get("ros__parameters")
            if isinstance(inner, dict):
                return name, inner
            found = found.get(name)
    return None


def value_below(root: dict[str, Any], name: str) -> Any:  # noqa: ANN401 - what yaml holds
    """Return the value of the first ``name`` in a file's mapping, in any depth; None where there is none."""
    if name in root:
        return root[name]
    for value in root.values():
        if isinstance(value, dict):
            found = value_below(value, name)
            if found is not None:
                return found
    return None
