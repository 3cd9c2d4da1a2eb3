"""Collision-free moves between two configurations of the arm: OMPL's RRTConnect, then shortcuts.

J. J. Kuffner, S. M. LaValle, "RRT-Connect", ICRA 2000, as in I. A. Sucan, M. Moll, L. E. Kavraki, "The Open Motion
Planning Library", IEEE Robotics and Automation Magazine 19, 2012; shortcuts as in R. Geraerts, M. H. Overmars,
"Creating high-quality paths for motion planning", International Journal of Robotics Research 26, 2007.
"""

from __future__ import annotations

import time
from typing import Callable, Iterator, List, Protocol, Sequence

import numpy as np
import ompl.base as ob
import ompl.geometric as og
import ompl.util as ou

from yarm.control.arm.collision import Clearance
from yarm.control.arm.errors import ArmError
from yarm.control.arm.model import JointLimits
from yarm.geometry.grid import FloatArray

STEP_RAD = 0.05
SHORTCUTS = 80
_SEEDS: List[int] = []
"""The seed that OMPL was given, once it was."""


class Surroundings(Protocol):
    """What a planner asks of a collision model; ``ArmCollision`` is one."""

    def clearance(self, q: FloatArray, within_m: float) -> Clearance:
        """Least distance at joints (n,), rad, as far as it is below ``within_m``."""

    def free(self, q: FloatArray, margin_m: float) -> bool:
        """Whether everything is further away than a margin."""


class ArmPlanner:
    """Plans in joint space; the sequence of answers depends on the seed alone. Not thread-safe."""

    def __init__(
        self,
        collision: Surroundings,
        limits: JointLimits,
        margin_m: float,
        seed: int,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Set up the space.

        Args:
            collision: what must not be touched.
            limits: of the joints.
            margin_m: distance kept to everything.
            seed: of the random numbers; OMPL takes it once a process.
            clock: seconds that a time limit counts; a thread's own does not run on while others have the core.
        """
        ou.setLogLevel(ou.LOG_WARN)
        _seed_ompl(seed)
        self._collision = collision
        self._limits = limits
        self._margin_m = margin_m
        self._clock = clock
        self._rng = np.random.default_rng(seed)
        self._n = len(limits.lower)
        self._space = ob.RealVectorStateSpace(self._n)
        bounds = ob.RealVectorBounds(self._n)
        for joint in range(self._n):
            bounds.setLow(joint, float(limits.lower[joint]))
            bounds.setHigh(joint, float(limits.upper[joint]))
        self._space.setBounds(bounds)

    def plan(self, start: FloatArray, goal: FloatArray, time_limit_s: float) -> FloatArray:
        """Corner points (m, n), rad, of a path whose straight pieces are free.

        Args:
            start: joints (n,).
            goal: joints (n,).
            time_limit_s: time by the clock after which it gives up.

        Raises:
            ArmError: an end is not free or out of limits, or no path was found.
        """
        for name, q in (("start", start), ("goal", goal)):
            self._check_end(name, q)
        if self.straight_is_free(start, goal):
            return np.array([start, goal])
        begun_s = self._clock()
        deadline_s = begun_s + time_limit_s
        while self._clock() < deadline_s:
            found = self._searched(start, goal, deadline_s)
            if not found:
                break
            # OMPL looks at a piece at other points than are looked at here, and a shortcut begins within a piece.
            corners = self._shortened(found)
            if all(self.straight_is_free(a, b) for a, b in zip(corners[:-1], corners[1:])):
                return corners
        spent = f"{self._clock() - begun_s:.3g} of {time_limit_s:g} s"
        raise ArmError(f"no path found in {spent} from {_words(start)} to {_words(goal)} deg")

    def _searched(self, start: FloatArray, goal: FloatArray, deadline_s: float) -> List[FloatArray]:
        """Corners of a path as the search leaves it; none when it finds none in time."""
        setup = og.SimpleSetup(self._space)
        setup.setStateValidityChecker(lambda state: self._free(self._joints(state)))
        setup.getSpaceInformation().setStateValidityCheckingResolution(STEP_RAD / self._space.getMaximumExtent())
        setup.setStartAndGoalStates(self._state(start), self._state(goal))
        setup.setPlanner(og.RRTConnect(setup.getSpaceInformation()))
        ended = ob.PlannerTerminationCondition(lambda: bool(self._clock() > deadline_s))
        if not setup.solve(ended) or not setup.haveExactSolutionPath():
            return []
        return [self._joints(state) for state in setup.getSolutionPath().getStates()]

    def straight_is_free(self, start: FloatArray, goal: FloatArray) -> bool:
        """Whether every configuration of a straight piece is free."""
        steps = max(int(np.ceil(np.max(np.abs(goal - start)) / STEP_RAD)), 1)
        return all(self._free(start + (goal - start) * i / steps) for i in _coarse_first(steps))

    def _free(self, q: FloatArray) -> bool:
        return self._collision.free(q, self._margin_m)

    def _check_end(self, name: str, q: FloatArray) -> None:
        if not self._limits.contain(q):
            raise ArmError(f"{name} {_words(q)} deg is out of the joints' limits")
        clearance = self._collision.clearance(q, self._margin_m)
        if clearance.distance_m < self._margin_m:
            raise ArmError(
                f"{name} {_words(q)} deg: {clearance.between} are {clearance.distance_m:.3f} m apart, "
                f"{self._margin_m:g} m is kept"
            )

    def _state(self, q: FloatArray) -> ob.State:
        state = self._space.allocState()
        for joint in range(self._n):
            state[joint] = float(q[joint])
        return state

    def _joints(self, state: ob.State) -> FloatArray:
        return np.array([state[joint] for joint in range(self._n)])

    def _shortened(self, corners: List[FloatArray]) -> FloatArray:
        """Leave out corners, and cut between random points of the path, wherever the straight piece is free."""
        for _ in range(SHORTCUTS):
            if len(corners) < 3:
                break
            first, last = sorted(self._rng.uniform(0.0, len(corners) - 1.0, 2))
            if int(last) == int(first):
                continue
            a, b = _between(corners, first), _between(corners, last)
            if self.straight_is_free(a, b):
                corners = [*corners[: int(first) + 1], a, b, *corners[int(last) + 1 :]]
        return np.array(_distinct(corners))


def _seed_ompl(seed: int) -> None:
    """Seed OMPL once a process: it refuses a second seed with an error and goes on with the first."""
    if not _SEEDS:
        _SEEDS.append(seed)
        ou.RNG.setSeed(seed)


def _coarse_first(last: int) -> Iterator[int]:
    """0 to ``last``, far apart first: what is not free is soon found."""
    stride = 1 << last.bit_length()
    yield 0
    while stride > 0:
        yield from range(stride, last + 1, 2 * stride)
        stride //= 2


def _between(corners: Sequence[FloatArray], at: float) -> FloatArray:
    index = min(int(at), len(corners) - 2)
    point: FloatArray = corners[index] + (at - index) * (corners[index + 1] - corners[index])
    return point


def _distinct(corners: Sequence[FloatArray]) -> List[FloatArray]:
    kept = [corners[0]]
    for corner in corners[1:-1]:
        if np.max(np.abs(corner - kept[-1])) > 1e-3:
            kept.append(corner)
    return [*kept, corners[-1]]


def _words(q: FloatArray) -> str:
    return "(" + ", ".join(f"{v:.0f}" for v in np.degrees(q)) + ")"
