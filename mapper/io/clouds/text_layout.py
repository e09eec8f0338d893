"""How numbers stand in the lines of a text: what separates them, and whether their decimals follow a comma."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from mapper.core.errors import ReadError
from mapper.io.clouds.numbers import as_python_writes

SAMPLE_LINES = 500  #: from which the layout is told
_DECIMAL = re.compile(rb"[-+]?(?:\d+(?:,\d+)?|,\d+)(?:[dDeE][-+]?\d+)?|[-+]?(?:nan|inf|1[.,]#\w+)", re.IGNORECASE)
_WITH_BOTH = re.compile(rb"[-+]?\d{1,3}(?:,\d{3})+\.\d+|[-+]?\d{1,3}(?:\.\d{3})+,\d+")
_THOUSANDS = re.compile(rb"[-+]?\d{1,3}(?:,\d{3})+(?:\.\d*)?")
_QUOTED = re.compile(rb'"([^"\n]*)"')
_DIGITS = re.compile(rb"\d+")
_INTEGER = re.compile(rb"[-+]?\d+")


@dataclass(frozen=True, slots=True)
class Layout:
    """``separator`` stands between numbers: ``,``, ``;``, a tab, or a blank for any number of blanks.

    ``decimal_commas`` says that a comma within a number is its decimal point. ``quoted`` says that numbers are quoted.
    ``words`` are the numbers of columns that hold something else.
    """

    separator: str
    decimal_commas: bool = False
    quoted: bool = False
    words: tuple[int, ...] = ()

    def plain(self, text: bytes) -> bytes:
        """Return lines of numbers with blanks between them and points for decimals.

        An empty field is ``nan``, and each of a column of :attr:`words`.
        """
        if self.quoted:
            text = _unquoted(text)
        separator = self.separator.encode()
        for column in self.words:
            field = rb"[^\r\n%b]*" % separator
            begin = rb"^(?![ \t]*#)(?=[^\n]*%b)((?:%b%b){%d})" % (separator, field, separator, column)
            text = re.sub(begin + field, rb"\g<1>nan", text, flags=re.MULTILINE)
        if self.decimal_commas and self.separator == ",":  # a comma and blanks separate, a comma alone does not
            text = re.sub(rb",[ \t]+", b" ", text)
        if self.decimal_commas:
            text = text.replace(b",", b".")
        if self.separator != " ":
            text = re.sub(re.escape(separator) + rb"[ \t]*(?=\r?\n|\Z)", b"", text)
            if separator * 2 in text:
                text = re.sub(re.escape(separator) + rb"(?=" + re.escape(separator) + rb")", separator + b"nan", text)
        for other in (b",", b";", b"\t"):
            text = text.replace(other, b" ")
        return text

    def numbers(self, line: bytes) -> list[float] | None:
        """Return the numbers of one line; None where something in it is none."""
        try:
            return [float(word) for word in as_python_writes(self.plain(line)).split()]
        except ValueError:
            return None


def layout_of(lines: Sequence[bytes]) -> Layout:
    """Return how numbers stand in lines that have nothing else, at most :data:`SAMPLE_LINES` of which are looked at.

    Raises :class:`ReadError` where commas stand between the numbers and within them, and for separators of thousands.
    """
    sample = [line.strip() for line in lines[:SAMPLE_LINES] if line.strip()]
    quoted = any(b'"' in line for line in sample)
    if quoted:
        is_decimal = any(b"," in inner for line in sample for inner in _QUOTED.findall(line))
        bare = [_QUOTED.sub(b"0", line) for line in sample]
        separator = ";" if any(b";" in line for line in bare) else "," if any(b"," in line for line in bare) else " "
        return Layout(separator, is_decimal and separator != ",", quoted=True)
    has_comma = any(b"," in line for line in sample)
    if any(b";" in line for line in sample):
        if any(_WITH_BOTH.fullmatch(word.strip()) for line in sample for word in line.split(b";")):
            raise _thousands()
        return Layout(";", has_comma)
    words = [line.split() for line in sample]
    if not has_comma:
        return Layout(" ")
    if all(len(one) >= 3 for one in words):
        if all(_DECIMAL.fullmatch(word) for one in words for word in one):
            return Layout(" ", decimal_commas=True)
        if all(word.endswith(b",") for one in words for word in one[:-1]) and all(
            _DECIMAL.fullmatch(word.removesuffix(b",")) for one in words for word in one
        ):
            inner = any(b"," in word.removesuffix(b",") for one in words for word in one)
            return Layout(",", decimal_commas=inner)
        with_comma = [word for one in words for word in one if b"," in word]
        if all(map(_DECIMAL.fullmatch, with_comma)) and not all(map(_THOUSANDS.fullmatch, with_comma)):
            raise _decimal_commas("some numbers have decimal commas, others decimal points")
        if any(_THOUSANDS.fullmatch(word) for one in words for word in one) and not any(
            b"," in word and not _THOUSANDS.fullmatch(word) for one in words for word in one
        ):
            raise _thousands()
    if _is_cut_by_commas([line.split(b",") for line in sample]):
        raise _decimal_commas("the numbers have decimal commas, and commas stand between them too")
    return Layout(",")


def columns_of_words(lines: Sequence[bytes], layout: Layout) -> tuple[int, ...]:
    """Return the numbers of the columns in which not all fields are numbers, or empty; none between blanks.

    At most :data:`SAMPLE_LINES` are looked at.
    """
    found: set[int] = set()
    if layout.separator == " ":
        return ()
    for line in lines[:SAMPLE_LINES]:
        fields = (_unquoted(line) if layout.quoted else line).split(layout.separator.encode())
        if len(layout.numbers(line) or ()) != len(fields):
            found.update(k for k, field in enumerate(fields) if field.strip() and len(layout.numbers(field) or ()) != 1)
    return tuple(sorted(found))


def _thousands() -> ReadError:
    return ReadError(
        "cloud.thousands", "The numbers have commas or points between their thousands: save the file without them."
    )


def _decimal_commas(what: str) -> ReadError:
    return ReadError(
        "cloud.decimal_commas",
        f"As it seems, {what}: save the file with decimal points, or with decimal commas and semicolons, tabs or "
        "blanks between the columns.",
    )


def _is_cut_by_commas(rows: Sequence[Sequence[bytes]]) -> bool:
    """Return whether the fields between commas are whole numbers and decimals in turn: ``0,047,1,802,-1,423``.

    Of three numbers there are six fields or more, every second of which has no sign. They are decimals where one has
    zeros before it or the field before it is -0, as no whole number is written, or where all have as many digits.
    """
    if not rows or any(len(row) < 6 or len(row) != len(rows[0]) for row in rows):
        return False
    whole = [row[k].strip() for row in rows for k in (0, 2, 4)]
    decimals = [row[k].strip() for row in rows for k in (1, 3, 5)]
    if not all(map(_INTEGER.fullmatch, whole)) or not all(map(_DIGITS.fullmatch, decimals)):
        return False
    if any(len(decimal) > 1 and decimal.startswith(b"0") for decimal in decimals) or b"-0" in whole:
        return True
    return len(rows) > 2 and min(map(len, decimals)) == max(map(len, decimals)) >= 3


def _unquoted(text: bytes) -> bytes:
    """Return a text without its quotes; a comma within them is a decimal one."""
    return _QUOTED.sub(lambda found: found[1].replace(b",", b"."), text)
