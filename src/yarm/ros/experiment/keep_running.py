"""``rosrun yarm keep_running``: a launch file that outlives its ROS master.

    rosrun yarm keep_running full_system.launch scene:=2m1ma_bin

What roslaunch starts does not outlive the ROS master: roslaunch ends with it, and nodes that a dead master knew are
unknown to the next one. This starts the master itself (or uses one that is there), then roslaunch; when the master is
gone it ends what is left, starts or awaits the next master, and starts all of it again. Exit code: that of roslaunch,
when that ends by itself; 128 and the signal's number when it was told to end; 1 without a master. A person's stop,
which the master keeps (docs/safety.md), is handed on to the next one.
"""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
import xmlrpc.client
from contextlib import suppress
from typing import List, Optional, Sequence
from urllib.parse import urlparse

from yarm.ros.common import names
from yarm.ros.experiment.launcher import Family
from yarm.safety.restarts import Restarts

POLL_S = 0.25
ANSWER_S = 2.0
"""A master that has not answered by then does not answer, s."""
NAMED_S, HANGS_S = 3.0, 20.0
"""Wall time after which a master that answers nothing is named, and one of our own is killed, s."""
UP_S = 20.0
"""Wall time that a master has to come up, s."""
TOLD_S = 30.0
"""A master that is awaited is named so often, s."""
LOCAL_PORT = 11311
USAGE, NO_MASTER = 2, 1
GONE = -1
STOPPED_BY = f"/{names.SAFETY_STOPPED_BY}"


class _Transport(xmlrpc.client.Transport):
    """One that does not wait for ever."""

    def make_connection(self, host: object) -> object:  # type: ignore[override]
        connection = super().make_connection(host)  # type: ignore[arg-type]
        connection.timeout = ANSWER_S
        return connection


def pid_of_master(uri: str) -> Optional[int]:
    """Process of the ROS master at an address; None when it does not answer in time, ``GONE`` when there is none."""
    try:
        answer = _asked(uri, "getPid")
    except socket.timeout:
        return None
    except (OSError, xmlrpc.client.Error):
        return GONE
    return answer if isinstance(answer, int) else GONE


def _asked(uri: str, what: str, *arguments: object) -> object:
    """The master's answer; None for a no. Raises when it does not answer."""
    with xmlrpc.client.ServerProxy(uri, transport=_Transport()) as master:
        answer = getattr(master, what)("/keep_running", *arguments)
    return answer[2] if isinstance(answer, list) and len(answer) == 3 and answer[0] == 1 else None


def is_ours(uri: str) -> bool:
    """Whether an address is of this machine, where a master can be started."""
    host = urlparse(uri).hostname
    own = {"localhost", "127.0.0.1", socket.gethostname(), *map(os.environ.get, ("ROS_HOSTNAME", "ROS_IP"))}
    return host in own


class Keeper:
    """A master, a roslaunch call, and the signals that end both."""

    def __init__(self, launch: Sequence[str], uri: str) -> None:
        """Nothing is started yet.

        Args:
            launch: launch file of the package and its arguments.
            uri: of the ROS master.
        """
        self._call = ["roslaunch", "yarm", *launch]
        self._uri, self._port = uri, urlparse(uri).port or LOCAL_PORT
        self._own: Optional[subprocess.Popen[bytes]] = None
        self._restarts = Restarts()
        self._stopped_by = 0
        self._persons_stop: object = None

    def run(self) -> int:
        """Until roslaunch ends by itself, or this is told to end; the exit code."""
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, self._on_signal)
        foreign = pid_of_master(self._uri) != GONE or not is_ours(self._uri)
        began_s = time.monotonic()
        try:
            while self._up(foreign):
                code = self._live()
                if code is not None:
                    return code
                if self._stopped_by:
                    break
                verdict = self._restarts.died(-signal.SIGKILL, began_s, time.monotonic())
                began_s = time.monotonic()
                if not verdict.again:
                    _say(f"the ROS master at {self._uri} is gone for good: {verdict.reason}")
                    return NO_MASTER
                _say(f"the ROS master at {self._uri} is gone: everything ends, and is started again with the next one")
            return 128 + self._stopped_by if self._stopped_by else NO_MASTER
        finally:
            self._end_master()

    def _up(self, foreign: bool) -> bool:
        """A master answers: one of our own, or, where somebody else's was there, the next one of theirs."""
        if not foreign and pid_of_master(self._uri) == GONE:
            self._end_master()
            self._own = subprocess.Popen(["rosmaster", "--core", "-p", str(self._port)], start_new_session=True)
        began_s, told_s = time.monotonic(), -TOLD_S
        while not self._stopped_by:
            now_s = time.monotonic() - began_s
            if (pid_of_master(self._uri) or GONE) != GONE and self._hand_stop_on():
                return True
            if not foreign and (now_s > UP_S or (self._own is not None and self._own.poll() is not None)):
                _say(f"no ROS master came up at {self._uri} within {now_s:.0f} s; does another program use its port?")
                return False
            if foreign and now_s - told_s >= TOLD_S:
                told_s = now_s
                _say(f"waits for a ROS master at {self._uri}: start one (roscore)")
            time.sleep(POLL_S)
        return False

    def _hand_stop_on(self) -> bool:
        """Tell a new master who has stopped everything; whether it has heard, or there was nothing to tell."""
        if self._persons_stop is None:
            return True
        try:
            return _asked(self._uri, "setParam", STOPPED_BY, self._persons_stop) is not None
        except (OSError, xmlrpc.client.Error):
            return False

    def _live(self) -> Optional[int]:
        """One roslaunch from its start to its end: its exit code; None when it was ended here."""
        master = pid_of_master(self._uri)
        launch = subprocess.Popen(self._call, start_new_session=True)
        family = Family(launch)
        try:
            while launch.poll() is None and not self._stopped_by and self._same(master):
                family.look()
                time.sleep(POLL_S)
            ended = launch.poll() is not None and self._same(master)
        finally:
            family.stop()
        return launch.returncode if ended and not self._stopped_by else None

    def _same(self, master: Optional[int]) -> bool:
        """Whether the master is the one that it was; one that answers nothing is waited for, our own not for ever."""
        began_s, named = time.monotonic(), False
        while not self._stopped_by:
            found = pid_of_master(self._uri)
            if found is not None:
                self._note_stop(found == master)
                return found == master
            silent_s = time.monotonic() - began_s
            if silent_s > NAMED_S and not named:
                named = True
                _say(f"the ROS master at {self._uri} answers nothing for {silent_s:.0f} s")
            if silent_s > HANGS_S and self._own is not None:
                self._end_master()
                return False
        return True

    def _note_stop(self, same: bool) -> None:
        """Who has stopped everything, if somebody has; of the next master it is not asked, which would know nothing."""
        if same:
            with suppress(OSError, xmlrpc.client.Error):
                self._persons_stop = _asked(self._uri, "getParam", STOPPED_BY)

    def _end_master(self) -> None:
        if self._own is not None:
            with suppress(ProcessLookupError):
                self._own.kill()
            self._own.wait()
            self._own = None

    def _on_signal(self, number: int, _: object) -> None:
        self._stopped_by = number


def _say(what: str) -> None:
    sys.stderr.write(f"keep_running: {what}\n")
    sys.stderr.flush()


def main(arguments: List[str]) -> int:
    """The command; its exit code."""
    if not arguments or arguments[0].startswith("-"):
        sys.stderr.write("usage: keep_running LAUNCH_FILE [NAME:=VALUE ...]\n")
        return USAGE
    return Keeper(arguments, os.environ.get("ROS_MASTER_URI", f"http://localhost:{LOCAL_PORT}")).run()
