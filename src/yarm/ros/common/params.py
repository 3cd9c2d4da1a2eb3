"""Parameters of a node, read from the parameter server and checked (see ``yarm.params``)."""

from __future__ import annotations

from typing import Type, TypeVar

import rospy

from yarm.params import build

T = TypeVar("T")


def load_params(cls: Type[T]) -> T:
    """The node's private parameters as an instance of a parameter class.

    Raises:
        yarm.params.ParamError: unknown or wrong parameters; the message lists every one with what is allowed.
    """
    values = rospy.get_param("~", {})
    return build(cls, values, where=rospy.get_name())
