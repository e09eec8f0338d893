"""Parameter tables built from dataclass fields. The metadata of each field is a table row.

A config is a frozen dataclass whose fields are created with :func:`number`, :func:`choice` and :func:`flag`.
:func:`table_of` returns its rows, and :func:`check_fields` validates its values.
"""

from __future__ import annotations

import sys
from collections.abc import Hashable, Iterable, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from functools import cache
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, TypeVar, cast

from mapper.core.errors import ConfigError

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Value: TypeAlias = bool | int | float | str
"""Value of a parameter."""

Values: TypeAlias = dict[str, Value]
"""Parameters by name."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """One row of a parameter table. ``kind`` determines which of the other fields are used.

    ``number``: low ≤ value ≤ high in ``unit``, with a slider of step ``step``. ``choice``: one of ``choices``.
    ``flag``: a boolean. ``group`` names the panel that shows the row. ``only_for`` lists the choices of the table's
    first row (the model, the sensor's kind) for which the parameter is used; empty means all.
    """

    name: str
    label: str
    group: str
    kind: Literal["number", "choice", "flag"]
    initial: Value
    sentence: str
    unit: str = ""
    low: float = 0.0
    high: float = 0.0
    step: float = 0.0
    choices: tuple[str, ...] = ()
    only_for: tuple[str, ...] = ()

    def check(self, value: object) -> float | str | bool:
        """Return ``value`` converted to the row's type. Raise :class:`ConfigError`, naming the row, if invalid."""
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

    def _refused(self, value: object, expected: str) -> ConfigError:
        return ConfigError(
            f"parameter.{self.name}", f"{self.label} ({self.name}) must be {expected}, not {value!r:.80}."
        )


N = TypeVar("N", int, float)
C = TypeVar("C", bound="DataclassInstance")
_ROW = "parameter"  # the key of a field's row in its metadata


def number(
    label: str,
    group: str,
    initial: N,
    sentence: str,
    unit: str,
    low: float,
    high: float,
    step: float,
    only_for: tuple[str, ...] = (),
) -> N:
    """Return a config field for a number. The arguments are those of :class:`Parameter`."""
    row = Parameter("", label, group, "number", initial, sentence, unit, low, high, step, only_for=only_for)
    return cast("N", _field(row))


def choice(
    label: str, group: str, initial: str, sentence: str, choices: tuple[str, ...], only_for: tuple[str, ...] = ()
) -> str:
    """Return a config field for one of ``choices``."""
    row = Parameter("", label, group, "choice", initial, sentence, choices=choices, only_for=only_for)
    return cast("str", _field(row))


def flag(label: str, group: str, initial: bool, sentence: str) -> bool:
    """Return a config field for a boolean."""
    return cast("bool", _field(Parameter("", label, group, "flag", initial, sentence)))


def _field(row: Parameter) -> object:
    made: object = field(default=row.initial, metadata={_ROW: row})
    return made


@cache
def table_of(config: type) -> tuple[Parameter, ...]:
    """Return the rows of a config in field order. Fields without a row are not parameters."""
    return tuple(replace(entry.metadata[_ROW], name=entry.name) for entry in fields(config) if _ROW in entry.metadata)


def check_fields(config: object) -> None:
    """Replace each field of a frozen config with its checked value. Raise :class:`ConfigError` for an invalid value."""
    for row in table_of(cast("Hashable", type(config))):
        object.__setattr__(config, row.name, row.check(getattr(config, row.name)))


def with_values(config: C, values: Mapping[str, Any], what: str = "parameter") -> C:
    """Return a config with some values replaced. Raises the errors of :func:`check_names` and :func:`check_fields`."""
    check_names(values, table_of(cast("Hashable", type(config))), what)
    return replace(config, **values)


def changed_values(config: DataclassInstance, first: DataclassInstance) -> Values:
    """Return the values, by name, in which ``config`` differs from ``first``, a config of the same class."""
    before = asdict(first)
    return {name: value for name, value in asdict(config).items() if value != before[name]}


def check_names(values: Mapping[str, Any], table: Iterable[Parameter], what: str = "parameter") -> None:
    """Raise :class:`ConfigError` if ``values`` has a name that ``table`` lacks. ``what`` is used in the message."""
    names = {row.name for row in table}
    unknown = [name for name in values if name not in names]
    if unknown:
        raise ConfigError("parameter.unknown", f"There is no {what} {unknown[0]!r:.80}.")
