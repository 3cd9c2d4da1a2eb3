"""Who serves which goal: idle robots, open goals, and the pairs assigned (docs/planning.md, "Tasks").

The Commander's loop around it::

    queue = TaskQueue()
    while not queue.done:
        queue.update(robots, goals)                    # what the map shows now: every mobile robot, every open goal
        queue.process(request, keep_clear=part_area)   # assigns; request.goals and request.assignments are not read
        request = replace(request, goals=queue.goals, assignments=queue.assignments)
        plan = planner.plan(request, rng)              # ... send the steps, wait for arrival ...
        for robot, goal in queue.assignments.items():
            if arrived(robots[robot], queue.goals[goal], spec):
                task = queue.pop(robot)                # task.kind "Clear" has no body: nothing to delete

- ``update`` drops goals that are no longer shown (their robot is idle again), follows those that moved, adds new ones.
- ``process`` assigns idle robots: debris before targets before homes, the sum of the travel distances least; a goal no
  robot can reach is not assigned but listed in ``unreachable`` with the reason, and is tried again when the map changes.
  Goals that cannot be held at the same time wait for each other.
- An idle robot that stands inside ``keep_clear`` is given a goal of kind "Clear", named ``clear/<robot>``, made here: a
  place outside where it blocks nobody. Idle robots elsewhere are moved by the planner when they block somebody
  (``RobotPlan`` with an empty goal), without a task.
- ``reject(robot, reason)`` gives a goal back that the planner found INFEASIBLE.
"""

from __future__ import annotations
