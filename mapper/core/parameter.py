"""One row of a table of parameters, and what every config that holds one value for each row does with its table."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from typing import Any, Literal

from mapper.core.errors import ConfigError


@dataclass(frozen=True, slots=True)
class Parameter:
    """One row of a table of parameters; ``kind`` says which of the other fields are used.

    ``number``: low ≤ value ≤ high in ``unit``, with a slider of step ``step``. ``choice``: one of ``choices``.
    ``flag``: true or false. ``group`` names the panel that shows the row. ``only_for`` lists the choices of the
    table's first row (the model, the sensor's kind) for which the parameter is used; empty means all.
    """

    name: str
    label: str
    group: str
    kind: Literal["number", "choice", "flag"]
    initial: float | str | bool
    sentence: str
    unit: str = ""
    low: float = 0.0
    high: float = 0.0
    step: float = 0.0
    choices: tuple[str, ...] = ()
    only_for: tuple[str, ...] = ()

    def check(self, value: object) -> float | str | bool:
        """Return ``value`` as the row's type; raise :class:`ConfigError` that names the row for an invalid one."""
        if self.kind == "flag":
            if isinstance(value, bool):
                return value
            raise self._refused(value, "true or false")
        if self.kind == "choice":
            if isinstance(value, str) and value in self.choices:
                return value
            raise self._refused(value, "one of " + ", ".join(self.choices))
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= sys.float_info.max:
            raise self._refused(value, "a finite number")
        if not self.low <= value <= self.high:
            raise self._refused(value, f"between {self.low:g} and {self.high:g} {self.unit}".rstrip())
        return float(value)

    def _refused(self, value: object, wanted: str) -> ConfigError:
        return ConfigError(f"parameter.{self.name}", f"{self.label} ({self.name}) must be {wanted}, not {value!r:.80}.")


def check_fields(config: object, table: Iterable[Parameter]) -> None:
    """Replace each field of a frozen dataclass by its checked value; raise :class:`ConfigError` for an invalid one."""
    for row in table:
        object.__setattr__(config, row.name, row.check(getattr(config, row.name)))


def check_names(values: Mapping[str, Any], table: Iterable[Parameter], what: str = "parameter") -> None:
    """Raise :class:`ConfigError` for a name in ``values`` that the table lacks; ``what`` is used in its sentence."""
    names = {row.name for row in table}
    unknown = [name for name in values if name not in names]
    if unknown:
        raise ConfigError("parameter.unknown", f"There is no {what} {unknown[0]!r:.80}.")


def check_table(config: type, table: Iterable[Parameter]) -> None:
    """Raise :class:`AssertionError` unless a dataclass has the rows of ``table`` as fields, with the same defaults."""
    if {field.name: field.default for field in fields(config)} != {row.name: row.initial for row in table}:
        raise AssertionError(f"{config.__name__} and its table must have the same names and the same initial values.")
