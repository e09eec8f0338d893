"""The codes with which the server closes the stream's socket, and the sentence that the page shows for each."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class CloseCode:
    """One close code: ``cause`` is for developers, ``sentence`` is shown by the page.

    ``may_be_over``: the session may no longer exist; the page checks that before it reconnects.
    """

    code: int
    cause: str
    sentence: str
    may_be_over: bool = False


POLICY = CloseCode(
    1008,
    "no subprotocol, an origin that is not allowed, too many malformed commands, or too many commands",
    "The server closed the connection because this page sent something that is not allowed or too much of it.",
)
TOO_LONG = CloseCode(
    1009,
    "a text frame that is longer than the server reads",
    "The server closed the connection because this page sent a message that is too long.",
)
INTERNAL = CloseCode(
    1011, "a defect of the server", "The server closed the connection because of a defect in the service."
)
RESTARTING = CloseCode(1012, "the service stops or restarts", "The server does not answer.")
SIGNED_OUT = CloseCode(
    4401,
    "the cookie of the service's token has ended: its browser signed out, or 30 days have passed",
    "This browser has signed out: open the address that has the service’s token.",
)
REFUSED = CloseCode(
    4404,
    "there is no such session, or it takes no further browser; the reason is the error's code",
    "The server refused the connection: the session does not exist any more, or too many browsers watch it.",
    may_be_over=True,
)
NO_ACKS = CloseCode(
    4408,
    "no frame was acknowledged for 30 s: connect again",
    "The server closed the connection because this page did not answer for a long time.",
)
ENDED = CloseCode(
    4410, "the session has ended, or its class does not show it any more", "This session has ended.", may_be_over=True
)

CLOSE_CODES = (POLICY, TOO_LONG, INTERNAL, RESTARTING, SIGNED_OUT, REFUSED, NO_ACKS, ENDED)
