"""Who may look and who may command: addresses, origins and the token (docs/security.md).

Pure rules; ``yarm.console.server`` asks them with each request.
"""

from __future__ import annotations

import hmac
import ipaddress
import secrets
import stat
from collections import OrderedDict
from dataclasses import dataclass
from pathlib import Path
from typing import Callable
from urllib.parse import urlsplit

from yarm.console.limits import MOST_PEERS, Clock

LEAST_LENGTH = 24
"""Characters a token from a file must have at least: 24 of 64 are 144 bits."""
MADE_BYTES = 32
"""Random bytes of a token that is made."""
FORGIVEN_S = 60.0
"""After so long without a wrong token its sender is asked to wait no longer, s."""
FIRST_WAIT_S, LONGEST_WAIT_S = 0.25, 4.0
"""What the first wrong token costs its sender, and the most; each one doubles it, s."""


class TokenError(ValueError):
    """The token's file cannot be used; the message says why and what to do."""


def new_token() -> str:
    """A token nobody can guess."""
    return secrets.token_urlsafe(MADE_BYTES)


def read_token(path: Path) -> str:
    """The token in a file: its first line.

    Raises:
        TokenError: the file cannot be read, others may read it too, or what it holds is too short or no plain text.
    """
    try:
        mode = path.stat().st_mode
        words = path.read_text(encoding="ascii").split("\n")[0].strip()
    except (OSError, UnicodeDecodeError) as error:
        raise TokenError(f"token file {path}: {error}") from error
    if stat.S_IMODE(mode) & 0o077:
        raise TokenError(
            f"token file {path}: others may read it (mode {stat.S_IMODE(mode):o}, allowed 600): chmod 600 {path}"
        )
    if len(words) < LEAST_LENGTH or not all(c.isalnum() or c in "-_" for c in words):
        raise TokenError(
            f"token file {path}: its first line has {len(words)} characters, at least {LEAST_LENGTH} are needed, "
            "of letters, digits, - and _"
        )
    return words


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach who listens on an address."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def host_fault(host_header: str, own: str) -> str:
    """What is wrong with the host a browser believes to talk to.

    A page of somebody else's may let its own name point here and read what comes (DNS rebinding); numbers cannot be
    pointed anywhere.

    Args:
        host_header: the request's ``Host``.
        own: the address or name that the console was told to listen on.
    """
    host = urlsplit(f"//{host_header}").hostname or ""
    try:
        ipaddress.ip_address(host)
    except ValueError:
        if host not in ("localhost", own.lower()):
            return f"host {host!r} is not this console's: call it by its number, as it was printed"
    return ""


def origin_fault(origin: str, host_header: str) -> str:
    """What is wrong with the page that sends a request; a program that is no browser sends no origin.

    Args:
        origin: the request's ``Origin``; empty without one.
        host_header: its ``Host``.
    """
    if not origin or origin in (f"http://{host_header}", f"https://{host_header}"):
        return ""
    return f"origin {origin!r} is not the console's own page"


@dataclass
class _Record:
    wrong: int
    last_s: float


TOLD = 16
"""Wrong tokens of one peer that are told one by one; after these each double number is, so that no log fills."""


class TokenGate:
    """Compares tokens, and makes who gives wrong ones wait. Not thread-safe."""

    def __init__(self, token: str, clock: Clock, warn: Callable[[str], None]) -> None:
        """Nobody has been wrong yet.

        Args:
            token: the right one.
            clock: seconds that never go backwards.
            warn: takes a line about each wrong token; never the token itself.
        """
        self._token, self._clock, self._warn = token.encode(), clock, warn
        self._records: OrderedDict[str, _Record] = OrderedDict()

    def wait_s(self, peer: str) -> float:
        """How long a token of a peer has to wait now before it is looked at, s; 0 for who has not been wrong."""
        record = self._records.get(peer)
        if record is None or self._clock() - record.last_s > FORGIVEN_S:
            self._records.pop(peer, None)
            return 0.0
        return min(LONGEST_WAIT_S, FIRST_WAIT_S * 2.0 ** min(record.wrong - 1, 16))

    def right(self, peer: str, given: str) -> bool:
        """Whether a token is the right one; a wrong one is remembered and told (TOLD), an empty one just not right."""
        if hmac.compare_digest(given.encode("utf-8", "replace"), self._token):
            return True
        if given:
            self.wait_s(peer)
            record = self._records.setdefault(peer, _Record(0, 0.0))
            record.wrong, record.last_s = record.wrong + 1, self._clock()
            self._records.move_to_end(peer)
            if len(self._records) > MOST_PEERS:
                self._records.popitem(last=False)
            if record.wrong <= TOLD or record.wrong & (record.wrong - 1) == 0:
                self._warn(
                    f"wrong token from {peer}, number {record.wrong}: the next one waits {self.wait_s(peer):g} s"
                )
        return False
