"""Command line ``commander_cli``: drives the Commander from a terminal, with progress, and waits for the end.

    rosrun yarm commander_cli run --mode boundless     # from whatever state to the mode, until its tasks are done
    rosrun yarm commander_cli status
    rosrun yarm commander_cli stop                      # every robot stops at its present waypoint
    rosrun yarm commander_cli wait --timeout 300
    rosrun yarm commander_cli cleanup                   # everybody home, switched off

Exit code: 0 succeeded, 1 failed or stopped, 2 no answer in time or no news of the Commander, 3 refused.
"""

from __future__ import annotations

import argparse
import sys
import time
from typing import Any, Dict, List, Optional, Sequence, Tuple

import rospy
from std_msgs.msg import Float32, Int8

from yarm.commander.activity import Ending
from yarm.commander.states import State
from yarm.control.sander.states import SanderState
from yarm.geometry.kinds import ObjectKind
from yarm.msg import CommanderStatus, ObjectRegistry
from yarm.ros.commander.reports import task_text
from yarm.ros.common import names
from yarm.ros.common.start import init_command
from yarm.ros.common.status_age import LOST_S, STALE_S, entered_since, silence
from yarm.srv import StateChange, StateChangeRequest

SUCCEEDED, FAILED, NO_ANSWER, REFUSED = 0, 1, 2, 3
LINE_PERIOD_S = 1.0
POLL_S = 0.1
ASK_AGAIN_S = 1.0
FIRST_WORD_S = 10.0
"""``status`` waits this long for a first word, wall time, s."""
DONE = 0.999
"""Share of a raster that counts as all of it."""


class CliError(RuntimeError):
    """The command ends here; ``code`` is the exit code."""

    def __init__(self, code: int, message: str) -> None:
        """An exit code and what to tell the user."""
        super().__init__(message)
        self.code = code


class Session:
    """What is heard of the Commander, and the means to ask it."""

    def __init__(self, timeout_s: float) -> None:
        """Connect; everything together may take so much wall time, s."""
        self._deadline = time.monotonic() + timeout_s
        self._timeout_s = timeout_s
        self._status: Optional[CommanderStatus] = None
        self._raster: Dict[str, float] = {}
        self._line = ""
        self._line_at = 0.0
        self._silence_said = False
        self._service = rospy.ServiceProxy(names.COMMANDER_STATE, StateChange)
        self._subscriber = rospy.Subscriber(names.COMMANDER_STATUS, CommanderStatus, self._on_status, queue_size=10)
        self._sander: Dict[str, int] = {}
        self._arms: Dict[str, List[rospy.Subscriber]] = {}

    def status(self) -> CommanderStatus:
        """The newest status.

        Raises:
            CliError: the Commander has not been heard of in time.
        """
        node, topic = names.COMMANDER_NODE, names.COMMANDER_STATUS
        heard = f"{topic}: nothing heard from {node} for as long; is it running?"
        self._wait(lambda: self._status is not None and rospy.get_time() > 0.0, heard)
        assert self._status is not None
        return self._status

    def silence(self, limit_s: float) -> str:
        """Why the newest status is no news, when it is older than a limit, s of simulated time; empty when it is."""
        return "" if self._status is None else silence(self._status, rospy.get_time(), limit_s)

    def ask(self, quiet: bool = False, **fields: Any) -> None:
        """Request a change of state, and wait until the status shows it; ``quiet`` leaves the answer out.

        A Commander that dies meanwhile is started again: it is asked once more unless it has carried the request out.

        Raises:
            CliError: refused, or no answer.
        """
        before = self.status()
        while True:
            left = max(0.1, self._deadline - time.monotonic())
            try:
                rospy.wait_for_service(names.COMMANDER_STATE, timeout=left)
                answer = self._service(StateChangeRequest(**fields))
                break
            except rospy.ROSException as error:
                raise CliError(NO_ANSWER, f"{names.COMMANDER_STATE} does not answer: {error}") from error
            except rospy.ServiceException as error:
                self.say(f"{names.COMMANDER_STATE} does not answer: {error}")
                failed_s = rospy.get_time()
                self._wait(lambda at=failed_s: self.status().header.stamp.to_sec() > at, "a Commander that answers")
            if entered_since(self.status(), before):
                return
        if not answer.success:
            raise CliError(REFUSED, answer.message)
        if not quiet:
            self.say(answer.message)
        self._wait(lambda: entered_since(self._status or before, before), "commander/status after the request")

    def until_idle(self, wanted: Optional[State] = None) -> CommanderStatus:
        """Show progress until the Commander is not busy.

        Raises:
            CliError: it is busy for too long.
        """
        self._wait(lambda: self._idle(wanted), "the end of the work (commander_cli stop ends it)")
        return self.status()

    def sanding(self) -> bool:
        """A manipulator is at work, and its raster is not done."""
        return any(
            self._sander.get(arm) == SanderState.SCAN_TO_PATH and share < DONE
            for arm, share in list(self._raster.items())
        )

    def follow_raster(self, arm: str) -> None:
        """Listen to the progress of a manipulator."""
        if arm not in self._arms:
            self._arms[arm] = [
                rospy.Subscriber(topic, kind, lambda m, into=into: into.__setitem__(arm, m.data), queue_size=10)
                for topic, kind, into in (
                    (names.sander_progress(arm), Float32, self._raster),
                    (names.sander_state(arm), Int8, self._sander),
                )
            ]

    def follow_every_raster(self) -> None:
        """Listen to the progress of every manipulator of the cell."""
        self._registry = rospy.Subscriber(names.OBJECT_REGISTRY, ObjectRegistry, self._on_registry, queue_size=10)

    def pause(self, seconds: float) -> None:
        """Let wall time pass, with progress."""
        end = time.monotonic() + seconds
        self._wait(lambda: time.monotonic() >= end, "")

    def say(self, text: str) -> None:
        """One line on the terminal."""
        sys.stdout.write(text + "\n")
        sys.stdout.flush()

    def _idle(self, wanted: Optional[State]) -> bool:
        status = self._status
        return status is not None and not status.busy and (wanted is None or status.state == int(wanted))

    def _on_registry(self, message: ObjectRegistry) -> None:
        for entry in message.entries:
            if entry.object == ObjectKind.MANIPULATOR:
                self.follow_raster(entry.name)

    def _on_status(self, message: CommanderStatus) -> None:
        self._status = message

    def _wait(self, ready: object, what: str) -> None:
        while not ready():  # type: ignore[operator]
            if rospy.is_shutdown():
                raise CliError(NO_ANSWER, "interrupted")
            if time.monotonic() > self._deadline:
                raise CliError(NO_ANSWER, f"after {self._timeout_s:.0f} s still waiting for {what}")
            lost = self.silence(LOST_S)
            if lost:
                raise CliError(NO_ANSWER, lost)
            time.sleep(POLL_S)
            self._show()

    def _show(self) -> None:
        if self._status is None or time.monotonic() - self._line_at < LINE_PERIOD_S:
            return
        silent = self.silence(STALE_S)
        if bool(silent) != self._silence_said:
            self._silence_said = bool(silent)
            self.say(silent or f"{names.COMMANDER_NODE} is heard again")
        line = line_of(self._status, self._raster)
        if line != self._line:
            self._line, self._line_at = line, time.monotonic()
            self.say(line)


def line_of(status: CommanderStatus, raster: Dict[str, float]) -> str:
    """One line that says it all."""
    parts = [f"{status.header.stamp.to_sec():8.1f} s  {status.state_name}{' busy' if status.busy else ''}"]
    parts += [task_text(task) for task in status.tasks]
    parts += [f"{arm} raster {100.0 * share:.0f} %" for arm, share in sorted(raster.items())]
    if status.outcome:
        parts.append(status.outcome)
    if status.reason:
        parts.append(status.reason)
    return " | ".join(parts)


WAY_UP: Dict[State, Tuple[Dict[str, Any], State]] = {
    State.IDLE: ({"current_state": True}, State.STARTED),
    State.STARTED: ({"next_state": True}, State.CALIBRATION),
    State.CALIBRATION: ({"next_state": True}, State.MENU),
    State.CLEANUP: ({"current_state": True}, State.IDLE),
}
"""What leads from each state towards the menu, and where to: a status that is on its way still shows the old state."""
MODES: Dict[str, State] = {"bounded": State.BOUNDED, "boundless": State.BOUNDLESS}


def run_mode(session: Session, mode: State, arms: Optional[Sequence[str]], once: bool) -> int:
    """From whatever state into a mode, until its tasks are done and none of the manipulators is still sanding.

    ``arms`` names them; None for every one in the object registry.
    """
    if arms is None:
        session.follow_every_raster()
    for arm in arms or ():
        session.follow_raster(arm)
    while session.status().state not in (int(State.MENU), int(mode)):
        state = State(session.until_idle().state)
        if state in (State.BOUNDED, State.BOUNDLESS):
            session.ask(previous_state=True)
            session.until_idle()
        elif state is State.CALIBRATION and session.status().outcome != Ending.SUCCEEDED:
            raise CliError(FAILED, f"calibration {session.status().outcome}: {session.status().reason}")
        else:
            fields, target = WAY_UP[state]
            session.ask(**fields)
            session.until_idle(target)
    if session.status().state == int(State.MENU):
        session.until_idle()
        session.ask(jump_state=int(mode))
    status = session.until_idle(mode)
    while not once and status.outcome == Ending.SUCCEEDED and session.sanding():
        session.pause(ASK_AGAIN_S)
        session.ask(quiet=True, current_state=True)
        status = session.until_idle(mode)
    return finish(session, status)


def finish(session: Session, status: CommanderStatus) -> int:
    """Say how it ended; the exit code."""
    for task in status.tasks:
        session.say(f"{task.robot or '-'} > {task.goal} ({task.kind}): {task.status} {task.reason}".rstrip())
    session.say(f"{status.state_name}: {status.outcome or 'idle'} {status.reason}".rstrip())
    return SUCCEEDED if status.outcome in (Ending.SUCCEEDED, Ending.NONE) else FAILED


def parser() -> argparse.ArgumentParser:
    """The command line."""
    made = argparse.ArgumentParser(prog="commander_cli", description="Drives the Commander from a terminal.")
    commands = made.add_subparsers(dest="command", required=True)
    run = commands.add_parser("run", help="enter a mode from whatever state, and wait until its tasks are done")
    run.add_argument("--mode", choices=sorted(MODES), default="boundless")
    every = "manipulators whose sanding is waited for; without it every one of the cell"
    run.add_argument("--arms", nargs="*", default=None, help=every)
    run.add_argument("--once", action="store_true", help="end with the first tasks, though a manipulator still sands")
    commands.add_parser("status", help="say what the Commander is doing")
    commands.add_parser("stop", help="stop every robot at its present waypoint")
    commands.add_parser("wait", help="wait until the work has ended")
    commands.add_parser("cleanup", help="send everybody home and switch off")
    for command in commands.choices.values():
        default_s = FIRST_WORD_S if command.prog.endswith("status") else 900.0
        command.add_argument("--timeout", type=float, default=default_s, help="wall seconds this may take")
    return made


def execute(arguments: argparse.Namespace, session: Session) -> int:
    """Do what was asked; the exit code."""
    if arguments.command == "run":
        return run_mode(session, MODES[arguments.mode], arguments.arms, arguments.once)
    if arguments.command == "status":
        session.say(line_of(session.status(), {}))
        silent = session.silence(STALE_S)
        if silent:
            raise CliError(NO_ANSWER, silent)
        return SUCCEEDED
    if arguments.command == "stop":
        if session.status().busy:
            session.ask(previous_state=True)
        return finish(session, session.until_idle()) and SUCCEEDED
    if arguments.command == "wait":
        return finish(session, session.until_idle())
    return clean_up(session)


def clean_up(session: Session) -> int:
    """Everybody home, then IDLE."""
    if session.status().state in (int(State.BOUNDED), int(State.BOUNDLESS)):
        session.until_idle()
        session.ask(next_state=True)
    status = session.until_idle(State.CLEANUP)
    code = finish(session, status)
    session.ask(next_state=True)
    return code


def main(argv: Optional[List[str]] = None) -> int:
    """Parse, do, say how it ended; the exit code."""
    arguments = parser().parse_args(rospy.myargv(argv if argv is not None else sys.argv)[1:])
    init_command("commander_cli", disable_signals=False)
    session = Session(arguments.timeout)
    try:
        return execute(arguments, session)
    except CliError as error:
        session.say(str(error))
        return error.code
