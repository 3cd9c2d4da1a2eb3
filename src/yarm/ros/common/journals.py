"""The journal of a node that a supervisor starts again, beside the logs of its run (``yarm.safety.journal``)."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Callable, Optional, Type, TypeVar

import rospkg
import rospy

from yarm.records import RecordError, plain, read
from yarm.safety.journal import Found, Journal
from yarm.safety.supervise import LIFE, RESTARTS

T = TypeVar("T")
LONGEST = 1_000_000
"""A longer journal is begun anew with what still counts, bytes."""


class NodeJournal:
    """Journal of this node; nothing is written when no supervisor would start it again. Not thread-safe.

    Attributes:
        found: what the process before this one left; none for the first.
    """

    def __init__(self, node: str) -> None:
        """Look for what is to be taken up, and say so when it cannot be."""
        self._node = node
        self._journal: Optional[Journal] = None
        self.found = Found()
        life = os.environ.get(LIFE, "")
        if not life:
            return
        run = str(rospy.get_param("/run_id", "")) if rospy.has_param("/run_id") else ""
        path = Path(rospkg.get_log_dir()) / run / f"{node}.journal"
        self._journal, found = Journal.open(path, node, life)
        if RESTARTS not in os.environ:
            return
        self.found = found
        if found.complaint:
            rospy.logwarn("%s: %s", node, found.complaint)

    def last(self, kind: Type[T]) -> Optional[T]:
        """The newest record as a dataclass; None when there is none that can be read, which is said."""
        if not self.found.records:
            if RESTARTS in os.environ:
                rospy.logwarn("%s: nothing to take up: it starts afresh", self._node)
            return None
        try:
            return read(kind, self.found.records[-1])
        except RecordError as error:
            rospy.logwarn("%s: its journal is not understood, it starts afresh: %s", self._node, error)
            return None

    def begin(self, record: Any) -> None:
        """Start over with a dataclass's record: nothing before it counts any more."""
        self._write(lambda journal: journal.begin([plain(record)]))

    def append(self, record: Any, sync: bool = False) -> None:
        """Add a dataclass's record; with ``sync`` it outlives the machine's power, too."""
        self._write(lambda journal: journal.append(plain(record), sync))

    @property
    def long(self) -> bool:
        """Whether it should be begun anew."""
        return self._journal is not None and self._journal.size > LONGEST

    @property
    def kept(self) -> bool:
        """Whether anything is written at all."""
        return self._journal is not None

    def _write(self, work: Callable[[Journal], None]) -> None:
        """A disk that fails stops nobody; but what is written in part must not be taken up."""
        if self._journal is None:
            return
        try:
            work(self._journal)
        except OSError as error:
            rospy.logerr(
                "%s: its journal cannot be written: %s; after its death it will start afresh", self._node, error
            )
            journal, self._journal = self._journal, None
            try:
                journal.discard()
            except OSError as removal:
                rospy.logerr("%s: its journal cannot be removed either: %s", self._node, removal)
