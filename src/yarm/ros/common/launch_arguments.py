"""Launch arguments are checked before anything starts: all faults at once, with what is allowed and a non-zero exit.

A launch file calls ``rosrun yarm check_arguments name:=value ...`` as the command of a parameter, so that roslaunch
itself ends with an error when one is wrong.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Callable, Dict, List, Sequence

from yarm.resources import resource

MAX_SEED = 2**31 - 1
PLANNERS = ("yarm", "original", "ma_astar", "ompl_rrtconnect", "ompl_prmstar", "ompl_bitstar")
Check = Callable[[str], str]


def _one_of(*allowed: str) -> Check:
    def check(value: str) -> str:
        return "" if value in allowed else "must be one of " + ", ".join(allowed)

    return check


def _whole(low: int, high: int) -> Check:
    def check(value: str) -> str:
        try:
            return "" if low <= int(value) <= high else f"must be within {low} to {high}"
        except ValueError:
            return f"must be a whole number within {low} to {high}"

    return check


def _number(low: float, high: float) -> Check:
    def check(value: str) -> str:
        try:
            return "" if low <= float(value) <= high else f"must be within {low:g} to {high:g}"
        except ValueError:
            return f"must be a number within {low:g} to {high:g}"

    return check


def _scene(value: str) -> str:
    shipped = sorted(path.stem for path in resource("scenes").glob("*.yaml"))
    if value in shipped or Path(value).is_file():
        return ""
    return "no such scene; shipped: " + ", ".join(shipped) + "; or give the path of a YAML file"


def _recording(value: str) -> str:
    return "" if Path(value).is_file() else "no such file; give a recording, bag:=/path/to/run.bag"


_BOOL = _one_of("true", "false")


def _window(value: str) -> str:
    if value == "true" and not os.environ.get("DISPLAY"):
        return "needs a screen, and DISPLAY is not set: false shows nothing, xvfb-run gives a screen nobody sees"
    return _BOOL(value)


CHECKS: Dict[str, Check] = {
    "scene": _scene,
    "case": _scene,
    "seed": _whole(-1, MAX_SEED),
    "planner": _one_of(*PLANNERS),
    "backend": _one_of("fused", "pcl"),
    "mode": _one_of("bounded", "boundless"),
    "real_time_factor": _number(0.0, 100.0),
    "recording": _recording,
    "rate": _number(0.01, 100.0),
    "start": _number(0.0, 1e6),
    **dict.fromkeys(("rviz", "gui"), _window),
    **dict.fromkeys(("sync", "bag", "nodelets", "noise", "cleanup", "loop"), _BOOL),
}


def faults(arguments: Sequence[str]) -> List[str]:
    """What is wrong with the given ``name:=value`` words, each fault naming argument, value and what is allowed."""
    found = []
    for word in arguments:
        name, separator, value = word.partition(":=")
        if not separator or name not in CHECKS:
            found.append(f"launch argument {word!r}: unknown; known: {', '.join(CHECKS)}")
            continue
        fault = CHECKS[name](value)
        if fault:
            found.append(f"launch argument {name} = {value!r}: {fault}")
    return found
