"""How probable it is that one look at a tag is final, before going there: for the choice of viewpoints."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Tuple

import numpy as np

from yarm.params import param
from yarm.tags.face_view import FaceView, upright

STEEP_DEG, STEEP_STEP_DEG = 45.0, 20.0
"""From the first angle on a view gets worse; the weight is for so many degrees more."""


@dataclass(frozen=True)
class LookChance:
    """Weights of a logistic curve, fitted to the tags among 1200 rendered views that nothing is judged by.

    ``rosrun yarm reproduce --study tags --fit-views 1200`` fits them anew.
    """

    bias: float = param(1.322, "", "for a tag of which nothing is seen, from no distance", low=-100.0, high=100.0)
    share: float = param(5.58, "", "for the share of the face that is seen", low=-100.0, high=100.0)
    steep: float = param(-3.188, "", "for each 20 degrees beyond 45 from the face's normal", low=-100.0, high=100.0)
    distance: float = param(-2.248, "1/m", "for the distance from the box's middle", low=-100.0, high=100.0)

    def of(self, share: float, angle_deg: float, distance_m: float) -> float:
        """Probability, 0 to 1; 0 when nothing of the face is seen."""
        if share <= 0.0:
            return 0.0
        weights = (self.bias, self.share, self.steep, self.distance)
        score = sum(w * x for w, x in zip(weights, chance_features(share, angle_deg, distance_m)))
        return 1.0 / (1.0 + math.exp(-score))

    def of_view(self, view: FaceView) -> float:
        """Of a view from a planned place: what the robot and the other known boxes hide is left out."""
        face = upright(np.zeros((view.camera.height, view.camera.width), np.uint8), view)
        if face is None:
            return 0.0
        eye = view.T_world_optical[:2, 3]
        return self.of(face.share, view.angle_deg, math.hypot(view.box.x - eye[0], view.box.y - eye[1]))


def chance_features(share: float, angle_deg: float, distance_m: float) -> Tuple[float, float, float, float]:
    """What the weights belong to, in their order."""
    return 1.0, share, max(0.0, abs(angle_deg) - STEEP_DEG) / STEEP_STEP_DEG, distance_m
