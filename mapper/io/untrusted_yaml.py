"""YAML from untrusted sources: a loader with limits on nesting, number of values and integers.

A few lines of aliases can describe gigabytes, so the values behind each alias are counted again. PyYAML reads nested
lists recursively and integers of any length in quadratic time, and it raises errors of other types for values that do
not match their tag. libyaml parses the text, about ten times as fast as PyYAML's own parser; PyYAML constructs the
values, in about ten microseconds each.
"""

from __future__ import annotations

import re
from typing import Any, ClassVar

import yaml
from yaml._yaml import CParser
from yaml.composer import Composer
from yaml.constructor import SafeConstructor
from yaml.resolver import Resolver

_EXPONENT = re.compile(r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)[eE][-+]?\d{1,4}", re.ASCII)
LONGEST_INTEGER = 100  #: characters; the longest 64-bit integer is binary, with sign and underscores


class AliasError(yaml.MarkedYAMLError):
    """The text has an alias to a list or mapping within itself."""


class DepthError(yaml.MarkedYAMLError):
    """The text has more than ``most_levels`` nested lists and mappings."""


class CountError(yaml.MarkedYAMLError):
    """The text has more than ``most_values`` values."""


class UntrustedLoader(Composer, CParser, SafeConstructor, Resolver):
    """Loads plain values from untrusted text; raises :class:`yaml.YAMLError` for text that cannot be loaded.

    PyYAML's composer precedes that of libyaml, which cannot be overridden and has unlimited recursion.
    """

    most_levels: ClassVar[int] = 20  #: of lists, mappings and the value inside them
    most_values: ClassVar[int] = 10_000  #: with keys, lists and mappings; a whole Nav2 stack's file has some 1500
    _level = 0
    _count = 0
    _deepest = 0  #: maximum level within the node being composed

    def __init__(self, text: str) -> None:
        # libyaml rejects lone surrogates, which are not UTF-8, with a yaml.YAMLError.
        CParser.__init__(self, text.encode("utf-8", "surrogatepass"))
        Composer.__init__(self)
        SafeConstructor.__init__(self)
        Resolver.__init__(self)
        self._anchored: dict[str, tuple[int, int]] = {}  #: values and levels of each anchored node
        self.twice: list[tuple[str, int, int]] = []  #: duplicate keys of mappings, of which the last is used

    def compose_mapping_node(self, anchor: Any) -> yaml.MappingNode:  # noqa: ANN401 - PyYAML's own
        """Return the next mapping; duplicate keys are recorded in ``twice``."""
        node = super().compose_mapping_node(anchor)
        lines: dict[str, int] = {}
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode) and key.tag != "tag:yaml.org,2002:merge":
                line = key.start_mark.line + 1
                if key.value in lines:
                    self.twice.append((key.value, lines[key.value], line))
                lines[key.value] = line
        return node

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:  # noqa: ANN401 - PyYAML's own
        """Return the next node."""
        event = self.peek_event()
        mark: Any = event.start_mark if event is not None else None
        values, levels = 1, 1
        if isinstance(event, yaml.AliasEvent) and event.anchor in self.anchors:
            if event.anchor not in self._anchored:
                raise AliasError(None, None, f"{event.anchor!r:.40} is within itself", mark)
            values, levels = self._anchored[event.anchor]
        if self._level + levels > self.most_levels:
            raise DepthError(None, None, "it is nested too deeply", mark)
        if self._count + values > self.most_values:
            raise CountError(None, None, f"it has more than {self.most_values} values", mark)
        before, outside = self._count, self._deepest
        self._level += 1
        self._count += values
        self._deepest = self._level + levels - 1
        try:
            node = super().compose_node(parent, index)
        finally:
            self._level -= 1
        if isinstance(event, yaml.NodeEvent) and event.anchor is not None:
            self._anchored[event.anchor] = (self._count - before, self._deepest - self._level)
        self._deepest = max(self._deepest, outside)
        return node

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:  # noqa: ANN401 - PyYAML's own
        """Return the value of a node."""
        try:
            return super().construct_object(node, deep)
        except (ValueError, ArithmeticError, LookupError, AttributeError):
            problem = f"{node.value!r:.40} is no {node.tag.rpartition(':')[2]}"
            raise yaml.constructor.ConstructorError(None, None, problem, node.start_mark) from None

    def construct_yaml_float(self, node: yaml.ScalarNode) -> float:
        """Return a number, which may have an exponent without a point or sign, as in YAML 1.2 and ROS 2."""
        if _EXPONENT.fullmatch(node.value):
            return float(node.value)
        return float(super().construct_yaml_float(node))

    def construct_yaml_int(self, node: yaml.ScalarNode) -> int:
        """Return a 64-bit integer."""
        # Python does not limit bases other than ten, including YAML 1.1's 59:59:59.
        if len(node.value) <= LONGEST_INTEGER:
            value = super().construct_yaml_int(node)
            if -(2**63) <= value < 2**64:
                return value
        problem = f"the integer {node.value!r:.40} has more than 64 bits"
        raise yaml.constructor.ConstructorError(None, None, problem, node.start_mark)


UntrustedLoader.add_implicit_resolver("tag:yaml.org,2002:float", _EXPONENT, [*"-+.0123456789"])
UntrustedLoader.add_constructor("tag:yaml.org,2002:float", UntrustedLoader.construct_yaml_float)  # type: ignore[type-var] # stubs
UntrustedLoader.add_constructor("tag:yaml.org,2002:int", UntrustedLoader.construct_yaml_int)  # type: ignore[type-var] # stubs


def text_of(data: bytes) -> str:
    """Return a YAML text: UTF-8, or UTF-16 by its byte-order mark. Raises :class:`UnicodeDecodeError`."""
    return data.decode("utf-16" if data.startswith((b"\xff\xfe", b"\xfe\xff")) else "utf-8-sig")


def load_untrusted(text: str) -> Any:  # noqa: ANN401 - what yaml holds
    """Return the value of a YAML text. Raises :class:`yaml.YAMLError`."""
    return load_with_twice(text)[0]


def load_with_twice(text: str) -> tuple[Any, list[tuple[str, int, int]]]:
    """Return the value of a YAML text, and the duplicate keys of its mappings, with their lines.

    For duplicates only the last value is used. Raises :class:`yaml.YAMLError`.
    """
    loader = UntrustedLoader(text)
    try:
        return loader.get_single_data(), loader.twice
    finally:
        loader.dispose()


def where_and_why(error: yaml.MarkedYAMLError, text: str) -> str:
    """Return the line of an error in a text and what is wrong there, in plain words."""
    if error.problem_mark is None:
        return f": {error.problem}"
    number = error.problem_mark.line
    line = next(iter(text.splitlines()[number : number + 1]), "")
    why = error.problem
    if "\t" in line[: len(line) - len(line.lstrip())]:
        why = "it is indented with a tab, which YAML forbids: use blanks"
    elif re.search(r"\{\{[^{}]*\}\}", line):
        why = "it has a template’s {{ … }} in it: put the value into the file"
    elif "unknown escape character" in f"{error.problem}":
        why = "a backslash within double quotes begins an escape: put single quotes in their place"
    elif "another document" in f"{error.problem}":
        why = "a second document begins there, after ---: keep one of them"
    return f" in line {number + 1}: {why}"
