"""``rosrun yarm why GOAL``: why a goal is not served, or a robot does not go on, and what would change it.

    rosrun yarm why debris_2
    rosrun yarm why ankurbot_1

Without a name it asks about every task of the Commander that waits or is unreachable.

Exit code: 0 answered, 2 no answer in time, 3 nothing is called so.
"""

from __future__ import annotations

import argparse
import sys
from typing import List, Optional

import rospy

from yarm.commander.events import TaskState
from yarm.msg import CommanderStatus
from yarm.ros.common import names
from yarm.ros.common.start import init_command
from yarm.srv import Why

ANSWERED, NO_ANSWER, UNKNOWN = 0, 2, 3
LIMIT_S = 10.0
"""Wall time in which the Commander must be there and say how its tasks stand, s."""
ASKED_ABOUT = (TaskState.WAITING.value, TaskState.ASSIGNED.value, TaskState.UNREACHABLE.value)


def main(argv: Optional[List[str]] = None) -> int:
    """Ask, print, and give the exit code."""
    parser = argparse.ArgumentParser(prog="why", description="Why a goal is not served, or a robot does not go on.")
    parser.add_argument("subject", nargs="?", help="name of a goal or a robot; default: every task that waits")
    options = parser.parse_args(rospy.myargv(argv if argv is not None else sys.argv)[1:])
    init_command("why")
    try:
        rospy.wait_for_service(names.COMMANDER_WHY, timeout=LIMIT_S)
        subjects = [options.subject] if options.subject else _waiting()
        ask, code = rospy.ServiceProxy(names.COMMANDER_WHY, Why), ANSWERED
        for subject in subjects:
            answer = ask(subject)
            sys.stdout.write(f"{answer.text}\n")
            code = code if answer.success else UNKNOWN
        if not subjects:
            sys.stdout.write("no task waits\n")
        return code
    except (rospy.ROSException, rospy.ServiceException) as error:
        sys.stderr.write(f"why: {names.COMMANDER_WHY} does not answer: {error}\n")
        return NO_ANSWER


def _waiting() -> List[str]:
    """Goals of the Commander's tasks that wait, ordered."""
    status = rospy.wait_for_message(names.COMMANDER_STATUS, CommanderStatus, timeout=LIMIT_S)
    return sorted(task.goal for task in status.tasks if task.status in ASKED_ABOUT)
