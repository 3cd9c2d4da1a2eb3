"""What an object of the cell is, and what its contacts count as."""

from __future__ import annotations

from enum import Enum


class ObjectKind(str, Enum):
    """What an object is: equal to the word of ObjectRegistry, MapMetaData and scene files."""

    MOBILE = "Mobile"
    MANIPULATOR = "Manipulator"
    DEBRIS = "Debris"
    TARGET = "Target"
    OBSTACLE = "Obstacle"

    def __str__(self) -> str:
        """The word."""
        return str(self.value)


class ContactKind(str, Enum):
    """What a contact counts as: equal to the word of Contacts and of an experiment's results."""

    ALLOWED = "allowed"
    SANDER_DEBRIS = "sander_debris"
    FAILURE = "failure"

    def __str__(self) -> str:
        """The word."""
        return str(self.value)


GOAL_KINDS = (ObjectKind.DEBRIS, ObjectKind.TARGET)
"""What robots are sent to."""
ROBOT_KINDS = (ObjectKind.MOBILE, ObjectKind.MANIPULATOR)
"""What moves by itself, and has an action server."""
