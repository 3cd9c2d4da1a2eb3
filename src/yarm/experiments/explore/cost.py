"""What a whole run cost the machine: how fast it went, and each node's share of a core."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Tuple

from yarm.experiments.run.record import NodeUsage


@dataclass(frozen=True)
class RunCost:
    """From the robot's start to its end.

    Attributes:
        sim_s: simulated time that went by.
        wall_s: wall time that it took.
        nodes: what each process cost, most expensive first.
    """

    sim_s: float
    wall_s: float
    nodes: Tuple[NodeUsage, ...] = ()

    @property
    def real_time_factor(self) -> float:
        """Simulated seconds a second, beside whatever else the machine did; NaN when no time went by."""
        return self.sim_s / self.wall_s if self.wall_s > 0.0 else math.nan

    @property
    def cores(self) -> float:
        """Processor seconds of all nodes for a simulated second: so many cores keep up with time. NaN as above."""
        if not self.sim_s > 0.0:
            return math.nan
        return sum(node.cpu_share for node in self.nodes) * self.wall_s / self.sim_s
