"""Parameters of the camera watch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from yarm.params import param
from yarm.ros.common import names


@dataclass(frozen=True)
class CameraWatchParams:
    """What ``config/cell/camera_watch.yaml`` holds."""

    camera_topics: Tuple[str, ...] = param(
        tuple(names.camera_points(n) for n in (1, 2, 3, 4)), "", "depth clouds of the cameras to watch"
    )
    cloud_period: float = param(1.0, "s", "time between two clouds looked at of a camera", low=0.1, high=60.0)
    points: int = param(1000, "", "points near known solids looked at of a cloud, at most", low=100, high=20000)
    judge_every: int = param(3, "", "clouds of a camera between two judgements", low=1, high=100)
    window: float = param(6.0, "s", "a judgement takes the points of so long", low=1.0, high=600.0)
    named_shift: float = param(0.007, "m", "a camera off by this is named", low=0.001, high=1.0)
    named_turn: float = param(0.3, "deg", "and one turned by this", low=0.05, high=45.0)
    significance: float = param(3.0, "", "if that is so many deviations of its measurement", low=1.0, high=100.0)
    seed: int = param(1, "", "of the points that are drawn", low=0, high=2**31 - 1)
