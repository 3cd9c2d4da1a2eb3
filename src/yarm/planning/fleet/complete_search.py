"""The complete search: every order of moves through every cell at every allowed heading, until one is found or none is.

After the idea of LaCAM (K. Okumura, "LaCAM: search-based algorithm for quick multi-agent pathfinding", AAAI 2023): a
search over the configurations of all robots, whose successors are made when they are wanted, and which ends with a plan
or with the proof that there is none. docs/planning.md, "Never stuck", says how it goes.
"""

from __future__ import annotations

from typing import List, Optional, Sequence

from yarm.planning.fleet.fleet import Fleet, Move, Progress
from yarm.planning.fleet.joint_native import NativeJoint, Outcome, library_path
from yarm.planning.fleet.joint_plan import valid
from yarm.planning.roadmap.search import Path, shortened, straight_runs

WORK = 220_000_000
"""Look-ups of two robots in one call, about two seconds of a core."""
IMPROVING = 40_000_000
"""Look-ups to make a plan cheaper."""
MEMORY_BYTES = 384 << 20
"""What the configurations visited may take."""


class CompleteSearch:
    """A search for one problem that goes on where it stopped. Needs the built library. Not thread safe."""

    def __init__(self, fleet: Fleet, robots: Sequence[int]) -> None:
        """Nothing is searched yet.

        Args:
            fleet: spaces and targets.
            robots: those with a target.
        """
        path = library_path()
        assert path is not None
        self._joint = NativeJoint(path, fleet, MEMORY_BYTES)
        self._close = bool(fleet.close_pairs)
        self._robots = tuple(robots)
        self.outcome = Outcome.OPEN

    @property
    def visited(self) -> int:
        """Configurations visited."""
        return self._joint.visited

    @property
    def work(self) -> int:
        """Look-ups made."""
        return self._joint.work

    @property
    def by_exchange(self) -> bool:
        """Whether what is proved is so by the exchanges of equal robots that can be made, not by looking everywhere."""
        return self._joint.by_exchange

    @property
    def proved(self) -> bool:
        """Whether there is no plan for sure.

        Robots that start within each other's margin may keep less than a margin on their first moves; what they may do
        later is not known before, so nothing is proved of them.
        """
        return self.outcome is Outcome.IMPOSSIBLE and not self._close

    def run(self, fleet: Fleet, work: int = WORK) -> Optional[List[Move]]:
        """Search on; moves that bring every robot to its target, or None. What was found stays found.

        Args:
            fleet: the fleet this was made for, or an equal one.
            work: look-ups at most.
        """
        if self.outcome is Outcome.OPEN and self.outcome_within(work) is Outcome.FOUND:
            self._joint.improve(IMPROVING)
        if self.outcome is not Outcome.FOUND:
            return None
        moves = self._moves(fleet)
        return moves if valid(fleet, moves, self._robots) else None

    def outcome_within(self, work: int) -> Outcome:
        """Search on, but make no plan of what is found."""
        self.outcome = self._joint.run(work)
        return self.outcome

    def _moves(self, fleet: Fleet) -> List[Move]:
        """The plan found, each robot's way between two others' pulled tight."""
        state = Progress(fleet.starts)
        units = self._joint.plan()
        index = 0
        while index < len(units):
            i = units[index][0]
            way = [state.poses[i]]
            while index < len(units) and units[index][0] == i:
                way.append(units[index][1])
                index += 1
            path: Path = straight_runs(tuple(way))
            state.go(i, shortened(fleet.view(i, state.poses), path))
        return state.moves


def make_complete_search(fleet: Fleet, robots: Sequence[int]) -> Optional[CompleteSearch]:
    """A complete search; None where the library is not built."""
    return None if library_path() is None else CompleteSearch(fleet, robots)
