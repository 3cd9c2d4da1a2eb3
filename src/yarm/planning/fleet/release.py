"""A joint plan carried out without waiting for everybody: an action dependency graph, and which moves it releases.

After W. Hoenig, S. Kiesel, A. Tinka, J. W. Durham, N. Ayanian, "Persistent and robust execution of MAPF schedules in
warehouses", IEEE Robotics and Automation Letters, 2019. The moves of a joint plan are its nodes. A move waits for the
robot's own move before it, and for every earlier move of others whose sweep is not disjoint from its own (the edges,
``PlannedMove.after`` and ``behind``); then it is released, whatever the others do. So

- two moves being made at the same time are disjoint, for one of the two comes earlier; where it is seen how far a
  robot has come, the earlier one counts only with what is left of it;
- the first unfinished move waits for nothing: as long as moves end, the plan does too, however long each of them takes.
"""

from __future__ import annotations

from typing import Callable, Collection, Dict, List, Optional, Sequence, Set, Tuple

from yarm.planning.model.types import FleetPlan, PlannedMove, PlanRequest, Waypoint

Passed = Callable[[str, PlannedMove], bool]
"""Whether all that a robot's move under way has left to sweep is, with the margin, disjoint from a move of another."""


def never(_robot: str, _move: PlannedMove) -> bool:
    """Of somebody who does not see how far robots have come."""
    return False


def moves_of(request: PlanRequest, plan: FleetPlan) -> Tuple[PlannedMove, ...]:
    """The joint plan; of a planner that gives none, the steps it wants made at once."""
    if plan.moves:
        return plan.moves
    at = {robot.name: Waypoint(robot.column, robot.yaw_rad) for robot in request.robots}
    steps = sorted((name, entry.step) for name, entry in plan.robots.items() if entry.step is not None)
    return tuple(PlannedMove(name, at[name], step) for name, step in steps)


class ReleaseOrder:
    """The dependency graph of a joint plan being carried out: which moves wait, are under way, or finished."""

    def __init__(self, moves: Sequence[PlannedMove], under_way: Collection[str] = (), passed: Passed = never) -> None:
        """Nothing of the plan released yet.

        Args:
            moves: the joint plan in its order.
            under_way: robots whose moves under way it starts behind.
            passed: asked of moves under way that are not finished; what it says must stay so while the move goes on.
        """
        self.moves = tuple(moves)
        self._before: Set[str] = set(under_way)
        self._finished: Set[int] = set()
        self._released: Dict[str, List[int]] = {}
        self._passed = passed

    @property
    def left(self) -> Tuple[int, ...]:
        """Indices of the moves that are not finished."""
        return tuple(i for i in range(len(self.moves)) if i not in self._finished)

    def next_of(self, robot: str) -> Optional[int]:
        """Index of a robot's first move that is not finished; None when there is none."""
        return next((i for i in self.left if self.moves[i].robot == robot), None)

    def waits_for(self, index: int) -> Tuple[str, ...]:
        """Robots whose moves must end before a move is released, in order; its own robot when that is busy."""
        move = self.moves[index]
        names = {self.moves[k].robot for k in move.after if k not in self._finished and not self._is_past(k, move)}
        names |= {name for name in move.behind if name in self._before and not self._passed(name, move)}
        if self.next_of(move.robot) != index or move.robot in self._before or move.robot in self._released:
            names.add(move.robot)
        return tuple(sorted(names))

    def ready(self) -> List[int]:
        """Indices of the moves that wait for nobody, in order."""
        robots = {self.moves[i].robot for i in self.left}
        nexts = sorted(i for i in (self.next_of(robot) for robot in robots) if i is not None)
        return [i for i in nexts if self.moves[i].robot not in self._released and not self.waits_for(i)]

    def onward(self, robot: str) -> Optional[int]:
        """Index of the move that a robot under way may go on with, since it waits for nobody else; None for none."""
        own = (i for i in self.left if self.moves[i].robot == robot and i not in self._released.get(robot, ()))
        index = next(own, None)
        return index if index is not None and self.waits_for(index) in ((), (robot,)) else None

    def release(self, index: int) -> PlannedMove:
        """A ready move is being made from now on, or will be by its robot under way.

        Raises:
            ValueError: it is not ready.
        """
        move = self.moves[index]
        if index not in self.ready() and index != self.onward(move.robot):
            waits = ", ".join(self.waits_for(index)) or "nobody: it is finished"
            raise ValueError(f"move {index} of {move.robot} cannot be released: it waits for {waits}")
        self._released.setdefault(move.robot, []).append(index)
        return move

    def finish(self, robot: str) -> None:
        """All that a robot was given has ended where it was to end.

        What ends elsewhere is never finished: what waits for it goes on waiting, until there is a new plan.
        """
        self._before.discard(robot)
        self._finished.update(self._released.pop(robot, ()))

    def _is_past(self, earlier: int, move: PlannedMove) -> bool:
        """Whether the robot of an earlier move has been seen past all that it shares with a move."""
        robot = self.moves[earlier].robot
        return earlier in self._released.get(robot, ()) and self._passed(robot, move)
