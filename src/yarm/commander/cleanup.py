"""State CLEANUP: mobile robots go back to where they started, then manipulators go to storage."""

from __future__ import annotations

from typing import Dict, List, Set

from yarm.commander.assignment import HomeAssignments
from yarm.commander.goals import ActiveGoal, Purpose
from yarm.commander.messages import Action, DeleteDone, GoalDone, Outcome, Say, TaskView
from yarm.commander.mission import Mission, Tools
from yarm.commander.work import Work
from yarm.commander.world import World
from yarm.planning.types import Goal


def home_goals(world: World) -> Dict[str, Goal]:
    """Where each robot on the map started, by robot."""
    goals = {}
    for robot, home in sorted(world.homes.items()):
        if robot in world.robots and world.map is not None:
            column = world.map.spec.column_of((home.x, home.y))
            goals[robot] = Goal(f"home/{robot}", "Home", column, yaw_rad=home.yaw_rad, robot=robot)
    return goals


class Cleanup(Work):
    """Everybody home, then every manipulator to storage."""

    def __init__(self, world: World, tools: Tools) -> None:
        """Clean up."""
        super().__init__(world)
        self._way_home = Mission(world, tools, HomeAssignments(home_goals(world)))
        self._stored: Set[str] = set()
        self._retry_s = 0.0

    def start(self, now_s: float) -> List[Action]:
        """Start the way home."""
        return self._way_home.start(now_s)

    def advance(self, now_s: float) -> List[Action]:
        """First the mobile robots, then the manipulators."""
        if self._way_home.result is None:
            actions = self._way_home.advance(now_s)
            self.reason = self._way_home.reason
            return actions
        if self._way_home.result.outcome != "succeeded":
            self.finish("failed", self._way_home.result.reason)
            return []
        return self._store(now_s)

    def goal_done(self, goal: ActiveGoal, event: GoalDone, now_s: float) -> List[Action]:
        """A step home, or a manipulator's way to storage, has ended."""
        if goal.purpose is Purpose.STEP:
            return self._way_home.goal_done(goal, event, now_s)
        if goal.purpose is not Purpose.CLEANUP:
            return []
        if event.outcome is Outcome.SUCCEEDED:
            self._stored.add(goal.robot)
            return []
        self._retry_s = now_s + self.world.params.retry_s
        self.reason = f"{goal.robot} is not in storage: {event.outcome.value} {event.message}".rstrip()
        return [Say("warn", self.reason)]

    def delete_done(self, event: DeleteDone) -> List[Action]:
        """Deletions of an earlier mission may still be answered."""
        return self._way_home.delete_done(event)

    def tasks(self) -> List[TaskView]:
        """The ways home."""
        return [view for view in self._way_home.tasks() if view.kind == "Home"]

    def _store(self, now_s: float) -> List[Action]:
        world = self.world
        missing = [name for name in world.manipulators if name in world.answers and name not in self._stored]
        if not missing:
            self.finish("succeeded")
            return []
        actions: List[Action] = []
        for name in missing:
            goal = world.goals.active.get(name)
            if goal is not None and goal.purpose is Purpose.CLEANUP:
                if now_s - goal.sent_s > world.params.cleanup_timeout_s:
                    limit = world.params.cleanup_timeout_s
                    actions += world.goals.cancel(name, now_s, f"not in storage within {limit:g} s")
                    self.finish("failed", f"{name} is not in storage within {limit:g} s")
            elif name in world.connected and now_s >= self._retry_s:
                actions.append(world.goals.send(name, Purpose.CLEANUP, "CLEANUP", now_s))
        return actions
