"""What the console can ask of a system: the four things, and how they are answered."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping, NamedTuple, Protocol

from yarm.commander.requests import Request


@dataclass(frozen=True)
class Answer:
    """What became of a request.

    Attributes:
        success: it was done.
        message: what was done, or why not.
    """

    success: bool
    message: str


class Part(NamedTuple):
    """Something that seldom changes: a version, and a message of ``yarm.console.wire``."""

    version: int
    message: bytes


class Cell(Protocol):
    """A running system; each call may take long and is made on a thread of its own."""

    def change_state(self, request: Request) -> Answer:
        """Ask the Commander for a change of state."""

    def stop(self) -> Answer:
        """Stop every robot and arm, until ``release``."""

    def release(self) -> Answer:
        """Let them move again."""

    def why(self, subject: str) -> Answer:
        """Why a goal is not served, or a robot stands."""


class View(Protocol):
    """What a page shows; asked by the server's thread, so it must be quick."""

    def now_s(self) -> float:
        """The time it shows, s."""

    def parts(self) -> Mapping[str, Part]:
        """What seldom changes, by name: bodies, health, events; a page gets a part when its version is another."""

    def state(self) -> bytes:
        """All the rest, as it is now; a message of ``yarm.console.wire``."""
