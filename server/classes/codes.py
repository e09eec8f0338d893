"""The codes of classes: six letters that are easy to read from a screen and to type."""

from __future__ import annotations

import secrets

#: Consonants, so that no words arise, without those that are easily taken for one another.
LETTERS = "BCDFGHJKLMNPQRSTVWXZ"
LENGTH = 6


def new_code() -> str:
    """Return a random code, one of 64 million."""
    return "".join(secrets.choice(LETTERS) for _ in range(LENGTH))


def normalised(code: str) -> str:
    """Return a code as it was made, from what a person has typed: small letters, blanks and dashes are allowed."""
    return code.replace(" ", "").replace("-", "").upper()[:32]
