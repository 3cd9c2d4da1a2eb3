"""Failures of the arm's planning, each with a sentence that names the pose and the reason."""

from __future__ import annotations


class ArmError(Exception):
    """No motion was found; the arm stays where it is."""
