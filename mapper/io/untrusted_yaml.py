"""YAML of untrusted sources: a loader without aliases, with limits of nesting and of integers.

Few lines of aliases describe gigabytes, and PyYAML reads nested lists by recursion and integers of any length in
quadratic time. Besides its own errors, PyYAML raises others for values that are no instance of their tag.
"""

from __future__ import annotations

from typing import Any, ClassVar

import yaml

LONGEST_INTEGER = 100  #: characters; the longest integer of 64 bits is binary, with its sign and underscores


class AliasError(yaml.MarkedYAMLError):
    """The text has an alias."""


class DepthError(yaml.MarkedYAMLError):
    """The text has more lists and mappings inside one another than ``most_levels``."""


class UntrustedLoader(yaml.SafeLoader):
    """Loads plain values from untrusted text; raises :class:`yaml.YAMLError` for text that it cannot load."""

    most_levels: ClassVar[int] = 20  #: of lists, mappings and the value within them
    _level = 0

    def fetch_flow_collection_start(self, TokenClass: Any) -> None:  # noqa: ANN401, N803 - PyYAML's own
        """Count the open brackets: the scanner reads 1024 characters ahead, in time quadratic in their number."""
        if self.flow_level >= self.most_levels:
            raise self._too_deep(self.get_mark())
        super().fetch_flow_collection_start(TokenClass)

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:  # noqa: ANN401 - PyYAML's own
        """Return the next node."""
        event = self.peek_event()  # type: ignore[no-untyped-call] # PyYAML's stubs leave it out
        if self._level >= self.most_levels:
            raise self._too_deep(event.start_mark)
        if isinstance(event, yaml.AliasEvent):
            raise AliasError(None, None, "aliases are not allowed", event.start_mark)  # type: ignore[arg-type] # as PyYAML
        self._level += 1
        try:
            return super().compose_node(parent, index)
        finally:
            self._level -= 1

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:  # noqa: ANN401 - PyYAML's own
        """Return the value of a node."""
        try:
            return super().construct_object(node, deep)
        except (ValueError, ArithmeticError, LookupError, AttributeError):
            problem = f"{node.value!r:.40} is no {node.tag.rpartition(':')[2]}"
            raise yaml.constructor.ConstructorError(None, None, problem, node.start_mark) from None

    def construct_yaml_int(self, node: yaml.ScalarNode) -> int:
        """Return an integer of 64 bits."""
        # Bases other than ten, and of YAML 1.1 also 59:59:59, are not limited by Python itself.
        if len(node.value) <= LONGEST_INTEGER:
            value = super().construct_yaml_int(node)
            if -(2**63) <= value < 2**64:
                return value
        problem = f"the integer {node.value!r:.40} has more than 64 bits"
        raise yaml.constructor.ConstructorError(None, None, problem, node.start_mark)

    def _too_deep(self, mark: yaml.Mark) -> DepthError:
        return DepthError(None, None, "it is nested too deeply", mark)


UntrustedLoader.add_constructor("tag:yaml.org,2002:int", UntrustedLoader.construct_yaml_int)


def load_untrusted(text: str) -> Any:  # noqa: ANN401 - what yaml holds
    """Return the value of a YAML text. Raises :class:`yaml.YAMLError`."""
    return yaml.load(text, Loader=UntrustedLoader)  # noqa: S506 - a SafeLoader
