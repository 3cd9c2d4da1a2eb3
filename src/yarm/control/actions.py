"""What a MoveRobot goal may ask for, as written in its ``action`` field."""

from __future__ import annotations

from enum import Enum


class MobileAction(Enum):
    """Actions of a mobile robot; whatever is none of these is a pose goal."""

    CALIBRATE = "CALIBRATION"
    ABOUT_TIP = "False"
    """To a pose, turning about the end effector."""
    ABOUT_BODY = "True"
    """To a pose, turning about the body's centre."""
    PICK = "PICK"
    """To a pose over a piece, and pick it up with the hand; the piece's name follows."""
    DROP = "DROP"
    """To a pose over a bin, and let go what the hand holds; the bin's name follows."""

    @staticmethod
    def of(text: str) -> MobileAction:
        """What an ``action`` field means; anything that is no word of an action means ABOUT_TIP."""
        word = text.split(" ", 1)[0]
        if word in (MobileAction.PICK.value, MobileAction.DROP.value):
            return MobileAction(word)
        if text == MobileAction.CALIBRATE.value:
            return MobileAction.CALIBRATE
        return MobileAction.ABOUT_BODY if text in ("True", "true", "TRUE") else MobileAction.ABOUT_TIP


class SearchSpace(str, Enum):
    """What may be done with a robot, as its answer to CALIBRATION writes it (SPACE=...)."""

    XY = "XY"
    """It is moved in the plane."""
    SWITCH = "SWITCH"
    """It is switched on and off."""

    def answer(self, area: object) -> str:
        """The answer to a CALIBRATION goal, with the numbers of its area."""
        return f"SPACE={self.value}/AREA={area}"


class ArmAction(Enum):
    """Actions of a manipulator with a sander."""

    CALIBRATE = "CALIBRATION"
    ON = "ON"
    OFF = "OFF"
    CLEANUP = "CLEANUP"
