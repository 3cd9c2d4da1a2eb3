"""Parameters of the seed publisher."""

from __future__ import annotations

from dataclasses import dataclass

from yarm.params import param


@dataclass(frozen=True)
class SeedTfPublisherParams:
    """What ``config/cell/seed_tf_publisher.yaml`` holds."""

    warn_after_s: float = param(3.0, "s", "say on wall time which input is silent after this long", low=0.5, high=60.0)
    diagnostics_period_s: float = param(1.0, "s", "wall time between two messages on /diagnostics", low=0.1, high=60.0)
