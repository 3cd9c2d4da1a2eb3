"""What a script of the sander is made of: a generator that yields steps and is sent their results."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Generator, Optional, Protocol, Union

from yarm.control.arm.errors import ArmError
from yarm.control.arm.motion import ArmMotion


class Job(Protocol):
    """A computation under way; ``concurrent.futures.Future`` is one."""

    def done(self) -> bool:
        """Whether it has ended."""

    def result(self) -> Any:
        """Its result; raises what it raised."""


class DoneJob:
    """A computation carried out on the spot."""

    def __init__(self, function: Callable[[], Any]) -> None:
        """Call the function now; what it raises is kept for ``result``."""
        self._error: Optional[ArmError] = None
        self._result: Any = None
        try:
            self._result = function()
        except ArmError as error:
            self._error = error

    def done(self) -> bool:
        """Always."""
        return True

    def result(self) -> Any:
        """The function's result, or its error raised."""
        if self._error is not None:
            raise self._error
        return self._result


@dataclass(frozen=True)
class Compute:
    """Compute something; its result is sent back."""

    function: Callable[[], Any]


@dataclass(frozen=True)
class Follow:
    """Follow a motion; true is sent back when it ran to its end.

    Attributes:
        motion: where to go.
        until: it is braked when this becomes true.
        note: told at each reading how far along the tip's path the arm is, metres, also while it brakes.
    """

    motion: ArmMotion
    until: Callable[[], bool] = lambda: False
    note: Optional[Callable[[float], None]] = None


@dataclass(frozen=True)
class Wait:
    """Wait until something is true."""

    until: Callable[[], bool]


Step = Union[Compute, Follow, Wait]
Script = Generator[Step, Any, None]
