"""Reading of ROS parameter files: yaml with ``ros__parameters`` at some level.

Source: the design articles of ROS 2, Parameter YAML files.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from mapper.core.errors import ConfigError, LimitError, ReadError
from mapper.io.untrusted_yaml import (
    AliasError,
    CountError,
    DepthError,
    UntrustedLoader,
    load_with_twice,
    text_of,
    where_and_why,
)

MAX_BYTES = 1 << 20  #: the file of a whole Nav2 stack has about 20 kB
MAX_DEPTH = UntrustedLoader.most_levels
MOST_TWICE = 10  #: notes on duplicate keys
MAX_VALUES = UntrustedLoader.most_values


def read_parameter_file(path: str | os.PathLike[str]) -> bytes:
    """Return the bytes of a parameter file, at most one more than allowed. Raises :class:`ReadError`."""
    place = Path(path)
    try:
        with place.open("rb") as file:
            return file.read(MAX_BYTES + 1)
    except OSError as error:
        message = f"The file {place.name!r} cannot be read: {error.strerror}."
        raise ReadError("parameters.unreadable", message) from error


class ParameterFile(dict[str, Any]):
    """The mapping of a parameter file; ``notes`` are sentences on ignored content."""

    notes: tuple[str, ...] = ()


def parse_ros_parameters(data: bytes) -> ParameterFile:
    """Return the mapping in a parameter file's bytes.

    Raises :class:`ReadError`, naming the line if possible, for text that is not such a mapping, and :class:`LimitError`
    for more than 1 MiB or 10 000 values.
    """
    if len(data) > MAX_BYTES:
        raise LimitError(
            "parameters.too_large", f"A parameter file may have at most {MAX_BYTES} bytes, not {len(data)}."
        )
    try:
        text = text_of(data)
    except UnicodeDecodeError as error:
        message = f"The parameter file is not UTF-8 text: byte {error.start} is wrong."
        raise ReadError("parameters.text", message) from error
    try:
        root, twice = load_with_twice(text)
    except AliasError as error:
        raise ReadError("parameters.alias", f"The parameter file is endless: {error.problem}.") from error
    except DepthError as error:
        raise ReadError("parameters.depth", f"The parameter file is nested deeper than {MAX_DEPTH} levels.") from error
    except CountError as error:
        message = f"A parameter file may have at most {MAX_VALUES} keys, values and lists."
        raise LimitError("parameters.too_many", message) from error
    except yaml.MarkedYAMLError as error:
        message = f"The parameter file is malformed{where_and_why(error, text)}."
        raise ReadError("parameters.yaml", message) from error
    except yaml.YAMLError as error:
        raise ReadError("parameters.yaml", "The parameter file is malformed.") from error
    if not isinstance(root, dict):
        raise ReadError("parameters.yaml", "The parameter file holds no names with values.")
    file = ParameterFile(root)
    file.notes = tuple(
        f"The key {key!r:.80} occurs twice, in lines {first} and {last}: the latter alone counts, as in Nav2’s launch "
        "files."
        for key, first, last in twice[:MOST_TWICE]
    )
    return file


WILDCARDS = ("*", "**")  #: node names that match one name, or any names


def nodes_of(root: Mapping[str, Any]) -> Iterator[tuple[tuple[str, ...], dict[str, Any]]]:
    """Yield the fully qualified name and the parameters of each node of a file's mapping, in order.

    A node is a mapping with ``ros__parameters``. Namespaces are keys, or parts of a fully qualified name with ``/``, as
    written by ``ros2 param dump``; dots in a parameter's name separate levels. Raises :class:`ReadError` for a name
    with both a value and parameters of its own. If a node occurs repeatedly, its parameters are merged and the last
    value is used, as in rcl.
    """
    nodes: dict[tuple[str, ...], dict[str, Any]] = {}
    for path, parameters in _nodes_below(root, ()):
        nodes[path] = _merged(nodes.get(path, {}), parameters, "/".join(path))
    yield from nodes.items()


def _nodes_below(
    parameters: Mapping[str, Any], path: tuple[str, ...]
) -> Iterator[tuple[tuple[str, ...], dict[str, Any]]]:
    for key, value in parameters.items():
        if not isinstance(value, dict):
            continue
        if key == "ros__parameters":
            yield path, _with_levels(value, "/".join(path))
        else:
            yield from _nodes_below(value, (*path, *(part for part in str(key).split("/") if part)))


def _with_levels(parameters: Mapping[Any, Any], where: str) -> dict[str, Any]:
    """Return parameters with each dot in their names expanded to a level."""
    levels: dict[str, Any] = {}
    for name, value in parameters.items():
        inner = _with_levels(value, where) if isinstance(value, dict) else value
        first, *rest = str(name).split(".") if ".." not in f".{name}." else [str(name)]
        if len(rest) >= MAX_DEPTH:
            raise ReadError("parameters.depth", f"{where}: A name has more than {MAX_DEPTH} levels.")
        for level in reversed(rest):
            inner = {level: inner}
        levels[first] = _joined(levels[first], inner, f"{where}: {first:.80}") if first in levels else inner
    return levels


def _merged(first: dict[str, Any], other: dict[str, Any], where: str) -> dict[str, Any]:
    return first | {key: _joined(first[key], value, where) if key in first else value for key, value in other.items()}


def _joined(first: object, other: object, where: str) -> object:
    if isinstance(first, dict) and isinstance(other, dict):
        return _merged(first, other, where)
    if isinstance(first, dict) or isinstance(other, dict):
        raise ReadError("parameters.levels", f"{where} has a value, and parameters below it.")
    return other


def find_node(
    root: Mapping[str, Any], names: tuple[str, ...], declared: Collection[str] = ()
) -> tuple[str, dict[str, Any]] | None:
    """Return the parameters of the first node of ``names`` in a file's mapping, and its name.

    The node may be below any number of namespaces. Parameters of all nodes (``/**``) are used if the node ``declared``
    the name, or if they are blocks, and the node itself has no other value. A file with parameters of all nodes only
    applies to the first of the names if it has a declared name. None if the file has no such node. Raises the errors of
    :func:`nodes_of`.
    """
    of_all: dict[str, Any] = {}
    nodes: dict[str, dict[str, Any]] = {}
    for path, parameters in nodes_of(root):
        last = path[-1] if path else ""
        if last in WILDCARDS:
            of_all |= {key: value for key, value in parameters.items() if key in declared or isinstance(value, dict)}
        elif last in names:
            nodes.setdefault(last, parameters)
    for name in names:
        if name in nodes:
            return name, of_all | nodes[name]
    return (names[0], of_all) if of_all.keys() & set(declared) else None


def node_names(root: Mapping[str, Any]) -> list[str]:
    """Return the distinct node names of a file's mapping, in order."""
    return list(dict.fromkeys("/".join(path) for path, _ in nodes_of(root)))


def note_on_others(root: Mapping[str, Any], name: str) -> list[str]:
    """Return a note on the nodes of a name that :func:`find_node` did not use, such as those of other robots."""
    same = [node for node in node_names(root) if node.rsplit("/", 1)[-1] == name]
    if len(same) < 2:
        return []
    others = ", ".join(same[1:])
    return [f"The parameter file has {len(same)} nodes {name}: {same[0]:.80} is taken, not {others:.160}."]


def value_below(root: dict[str, Any], name: str) -> Any:  # noqa: ANN401 - what yaml holds
    """Return the value of the first ``name`` in a file's mapping, at any depth; None if there is none."""
    if name in root:
        return root[name]
    for value in root.values():
        if isinstance(value, dict):
            below = value_below(value, name)
            if below is not None:
                return below
    return None


def names_of(value: object, where: str) -> list[str]:
    """Return a list of names at ``where`` in a file. Raises :class:`ConfigError` for anything else."""
    if isinstance(value, list) and all(isinstance(name, str) for name in value):
        return value
    quoted = "; ROS 2 takes what is in quotes for a text" if isinstance(value, str) and "[" in value else ""
    raise ConfigError("nav2.plugins", f"{where} must be a list of names, not {value!r:.80}{quoted}.")


def with_node(
    root: Mapping[str, Any], name: str, parameters: Mapping[str, Any], path: tuple[str, ...]
) -> dict[str, Any]:
    """Return a file's mapping with the node found by :func:`find_node` replaced by these parameters.

    If the file has no such node it is added at ``path``. Everything else in the file is kept.
    """
    target = next((path for path, _ in nodes_of(root) if path and path[-1] == name), None)
    if target is not None:
        changed, _ = _replaced(root, (), target, parameters)
        return changed
    inner: Any = {"ros__parameters": {**parameters}}
    for key in reversed(path):
        inner = {key: inner}
    return _merged({**root}, inner, "/".join(path))


def _replaced(
    nodes: Mapping[str, Any], path: tuple[str, ...], target: tuple[str, ...], parameters: Mapping[str, Any] | None
) -> tuple[dict[str, Any], bool]:
    """Return a mapping with the parameters of the node ``target`` replaced at its first occurrence, and whether it
    occurs.

    At later occurrences its parameters are removed; None removes them everywhere.
    """
    replaced: dict[str, Any] = {}
    is_done = False
    for key, value in nodes.items():
        if not isinstance(value, dict):
            replaced[key] = value
        elif key == "ros__parameters":
            if path != target:
                replaced[key] = value
            elif parameters is not None and not is_done:
                replaced[key], is_done = {**parameters}, True
        else:
            below = (*path, *(part for part in str(key).split("/") if part))
            replaced[key], done = _replaced(value, below, target, None if is_done else parameters)
            is_done |= done
    return replaced, is_done
