"""Which of several sources of velocity commands is let through: the one of the highest priority that is not silent."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Optional, Sequence, Tuple

from yarm.params import ParamError, param


@dataclass(frozen=True)
class MuxInput:
    """A source of commands.

    Attributes:
        name: unique name.
        priority: the higher goes first; no two are equal.
        timeout_s: it holds its right for so long after a command, s.
    """

    name: str
    priority: int
    timeout_s: float


@dataclass(frozen=True)
class MuxParams:
    """What ``config/exploration/cmd_vel_mux.yaml`` holds; item by item one input."""

    inputs: Tuple[str, ...] = param(
        ("safety_controller", "teleop", "navi"), "", "the sources, each heard on cmd_vel_mux/input/<name>"
    )
    priorities: Tuple[int, ...] = param((10, 7, 5), "", "of each source; the higher goes first", low=0, high=1000)
    timeouts: Tuple[float, ...] = param(
        (0.2, 1.0, 1.0), "s", "each source holds its right for so long after a command", low=0.01, high=60.0
    )


def mux_inputs(params: MuxParams) -> Tuple[MuxInput, ...]:
    """The sources that parameters speak of.

    Raises:
        ParamError: lists of different lengths, or names or priorities that occur twice; all faults are listed.
    """
    lengths = {"inputs": len(params.inputs), "priorities": len(params.priorities), "timeouts": len(params.timeouts)}
    faults = []
    if len(set(lengths.values())) != 1 or not params.inputs:
        said = ", ".join(f"{name} has {length}" for name, length in lengths.items())
        faults.append(f"{said}: they must have one item for each source, and at least one")
    for name, values in (("inputs", params.inputs), ("priorities", params.priorities)):
        if len(set(values)) != len(values):
            faults.append(f"{name} = {list(values)}: no item may occur twice")
    if faults:
        raise ParamError("; ".join(faults))
    return tuple(MuxInput(*item) for item in zip(params.inputs, params.priorities, params.timeouts))


class Mux:
    """Decides command by command. It sends nothing of its own: a base that hears nothing stops by itself.

    Attributes:
        active: name of the source that has the right; None when all are silent.
    """

    def __init__(self, inputs: Sequence[MuxInput]) -> None:
        """Nobody has said anything."""
        self._inputs: Dict[str, MuxInput] = {item.name: item for item in inputs}
        self.active: Optional[str] = None
        self._last_s = 0.0

    def take(self, name: str, now_s: float) -> bool:
        """A command of a source has come at a time, s; whether it goes through."""
        self.expire(now_s)
        if self.active is not None and self._inputs[name].priority < self._inputs[self.active].priority:
            return False
        self.active, self._last_s = name, now_s
        return True

    def expire(self, now_s: float) -> None:
        """Take the right from a source that has been silent for longer than its timeout; one of a past run too."""
        if self.active is None:
            return
        silent_s = now_s - self._last_s
        if silent_s > self._inputs[self.active].timeout_s or silent_s < 0.0:
            self.active = None
