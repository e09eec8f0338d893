"""Layout of numbers in the lines of a text: separator, and decimal points or commas."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from mapper.core.errors import ReadError
from mapper.io.clouds.numbers import as_python_writes

SAMPLE_LINES = 500  #: lines from which the layout is determined
_DECIMAL = re.compile(rb"[-+]?(?:\d+(?:,\d+)?|,\d+)(?:[dDeE][-+]?\d+)?|[-+]?(?:nan|inf|1[.,]#\w+)", re.IGNORECASE)
_WITH_BOTH = re.compile(rb"[-+]?\d{1,3}(?:,\d{3})+\.\d+|[-+]?\d{1,3}(?:\.\d{3})+,\d+")
_THOUSANDS = re.compile(rb"[-+]?[1-9]\d{0,2}(?:,\d{3})+(?:\.\d*)?")
_GROUPS = re.compile(rb"[-+]?\d{1,3}(?:(?: \d{3})+|(?:'\d{3})+|(?:[,.]\d{3}){2,})(?:[,.]\d*)?")  #: other thousands
_BELOW_1000 = re.compile(rb"[-+]?\d{1,3}")
_REMARK = re.compile(rb"[ \t]#.*")  #: ``1.#INF`` directly follows a number
SEPARATORS = (b";", b"|", b"\t")  #: do not occur in numbers
_QUOTED = re.compile(rb'"([^"\n]*)"')
_DIGITS = re.compile(rb"\d+")
_INTEGER = re.compile(rb"[-+]?\d+")


@dataclass(frozen=True, slots=True)
class Layout:
    """``separator`` separates numbers: ``,``, ``;``, ``|``, a tab, or a blank for any number of blanks.

    ``decimal_commas`` means that a comma within a number is its decimal point. ``quoted`` means that numbers are
    quoted. ``words`` are the indices of columns with other content. ``is_closed`` means that each line ends in a
    separator, after which there is no field.
    """

    separator: str
    decimal_commas: bool = False
    quoted: bool = False
    words: tuple[int, ...] = ()
    is_closed: bool = False

    def plain(self, text: bytes) -> bytes:
        """Return lines of numbers separated by blanks with decimal points.

        Empty fields, and the columns in :attr:`words`, become ``nan``.
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
            last = re.escape(separator) + rb"[ \t]*(?=\r?\n|\Z)"
            text = re.sub(last, b"" if self.is_closed else separator + b"nan", text)
            if text.startswith(separator) or b"\n" + separator in text:
                text = re.sub(rb"^(?=" + re.escape(separator) + rb")", b"nan", text, flags=re.MULTILINE)
            if separator * 2 in text:
                text = re.sub(re.escape(separator) + rb"(?=" + re.escape(separator) + rb")", separator + b"nan", text)
        for other in (b",", *SEPARATORS):
            text = text.replace(other, b" ")
        return text

    def numbers(self, line: bytes) -> list[float] | None:
        """Return the numbers of one line; None if any field is not a number."""
        try:
            return [float(word) for word in as_python_writes(self.plain(_REMARK.sub(b"", line))).split()]
        except ValueError:
            return None


def layout_of(lines: Sequence[bytes]) -> Layout:
    """Return the layout of lines of numbers only, from at most :data:`SAMPLE_LINES` of them.

    Raises :class:`ReadError` if commas are used both between and within the numbers, and for thousands separators.
    """
    sample = [
        line for line in (_REMARK.sub(b"", line).strip(b" \r\n") for line in lines[:SAMPLE_LINES]) if line.strip()
    ]
    quoted = any(b'"' in line for line in sample)
    if quoted:
        in_quotes = [_QUOTED.findall(line) for line in sample]
        _refuse_thousands(in_quotes)
        bare = [_QUOTED.sub(b"0", line) for line in sample]
        separator = next(
            (separator for separator in (*SEPARATORS, b",") if any(separator in line for line in bare)), b" "
        ).decode()
        is_decimal = any(b"," in word for words_in_quotes in in_quotes for word in words_in_quotes) and separator != ","
        return Layout(separator, is_decimal, quoted=True, is_closed=_is_closed(bare, separator))
    has_comma = any(b"," in line for line in sample)
    for candidate in SEPARATORS:
        rows = [[field.strip() for field in line.split(candidate)] for line in sample]
        if candidate == b"\t" and not all(len(row) == len(rows[0]) > 2 for row in rows):
            continue
        if any(len(row) > 1 for row in rows):
            _refuse_thousands(rows)
            if candidate != b"\t":
                return Layout(candidate.decode(), has_comma, is_closed=_is_closed(sample, candidate.decode()))
    words = [line.split() for line in sample]
    if any(b"'" in word and _GROUPS.fullmatch(word) for line in words for word in line):
        raise _thousands()
    if not has_comma:
        return Layout(" ")
    if all(len(word) >= 3 for word in words):
        if all(_DECIMAL.fullmatch(word) for line in words for word in line):
            return Layout(" ", decimal_commas=True)
        if all(word.endswith(b",") for line in words for word in line[:-1]) and all(
            _DECIMAL.fullmatch(word.removesuffix(b",")) for line in words for word in line
        ):
            inner = any(b"," in word.removesuffix(b",") for line in words for word in line)
            return Layout(",", decimal_commas=inner)
        with_comma = [word for line in words for word in line if b"," in word]
        if all(map(_DECIMAL.fullmatch, with_comma)) and not all(map(_THOUSANDS.fullmatch, with_comma)):
            raise _decimal_commas("some numbers have decimal commas, others decimal points")
        if any(_THOUSANDS.fullmatch(word) for line in words for word in line) and not any(
            b"," in word and not _THOUSANDS.fullmatch(word) for line in words for word in line
        ):
            raise _thousands()
    if _is_cut_by_commas([line.split(b",") for line in sample]):
        raise _decimal_commas("the numbers have decimal commas, and commas stand between them too")
    if any(_GROUPS.fullmatch(field.strip()) for line in sample for field in line.split(b",")):
        raise _thousands()
    return Layout(",", is_closed=_is_closed(sample, ","))


def _is_closed(lines: Sequence[bytes], separator: str) -> bool:
    return all(line.rstrip().endswith(separator.encode().strip()) for line in lines) if separator.strip() else False


def _refuse_thousands(rows: Sequence[Sequence[bytes]]) -> None:
    """Raise :class:`ReadError` for fields (rows, columns) with thousands separators.

    A comma before three digits is one if the numbers below 1000 in the same column have none; among decimals without
    trailing zeros, some have fewer digits.
    """
    if any(_WITH_BOTH.fullmatch(field) or _GROUPS.fullmatch(field) for row in rows for field in row):
        raise _thousands()
    for k in range(min(map(len, rows), default=0)):
        column = [row[k] for row in rows]
        with_comma = [field for field in column if b"," in field]
        if with_comma and all(map(_THOUSANDS.fullmatch, with_comma)) and any(map(_BELOW_1000.fullmatch, column)):
            raise _thousands()


def columns_of_words(lines: Sequence[bytes], layout: Layout) -> tuple[int, ...]:
    """Return the indices of the columns with fields that are neither numbers nor empty; none if separated by blanks.

    At most :data:`SAMPLE_LINES` are examined.
    """
    chosen: set[int] = set()
    if layout.separator == " ":
        return ()
    for line in lines[:SAMPLE_LINES]:
        fields = (_unquoted(line) if layout.quoted else line).split(layout.separator.encode())
        if len(layout.numbers(line) or ()) != len(fields):
            chosen.update(
                k for k, field in enumerate(fields) if field.strip() and len(layout.numbers(field) or ()) != 1
            )
    return tuple(sorted(chosen))


def _thousands() -> ReadError:
    return ReadError(
        "cloud.thousands",
        "The numbers have commas, points or blanks between their thousands: save the file without them.",
    )


def _decimal_commas(what: str) -> ReadError:
    return ReadError(
        "cloud.decimal_commas",
        f"Apparently {what}: save the file with decimal points, or with decimal commas and semicolons, tabs or "
        "blanks between the columns.",
    )


def _is_cut_by_commas(rows: Sequence[Sequence[bytes]]) -> bool:
    """Return whether the fields between commas are alternating integers and decimals: ``0,047,1,802,-1,423``.

    Three numbers have at least six fields, every second of which has no sign. They are decimals if one has leading
    zeros or follows -0, which integers never do, or if all have the same number of digits.
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
    return _QUOTED.sub(lambda match: match[1].replace(b",", b"."), text)
