"""For benchmarks that listen to a system they have launched."""

from __future__ import annotations

import time

import rosgraph

ASK_S = 0.2
"""Between two looks at the ROS master, s of wall time."""


def await_simulated_time(caller: str, limit_s: float) -> None:
    """Until the launch has said that time is simulated: a node that begins before goes by the wall for good.

    Args:
        caller: who asks the ROS master.
        limit_s: wall time after which it goes on without.
    """
    deadline, master = time.monotonic() + limit_s, rosgraph.Master(f"/{caller}")
    while time.monotonic() < deadline:
        try:
            if master.hasParam("/use_sim_time"):
                return
        except (OSError, rosgraph.MasterException):
            pass  # not up yet
        time.sleep(ASK_S)
