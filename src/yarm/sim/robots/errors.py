"""Why a command to a robot was not taken."""

from __future__ import annotations


class CommandError(ValueError):
    """A command was refused; the message names the value and what is accepted."""
