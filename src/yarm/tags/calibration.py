"""From how well each tag lies on a face, and how much texture the face has, to a probability for every answer.

A softmax over the tags, blank and unknown, with few weights that all tags share. They were fitted to rendered views
(``yarm.experiments.study.tag_calibration``) and stand in ``config/inspection/tag_calibration.yaml``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, Mapping, Optional, Tuple

import numpy as np

from yarm.geometry import FloatArray
from yarm.params import build, param
from yarm.resources import resource
from yarm.yaml_fields import load_yaml

BLANK, UNKNOWN = 0, -1
"""Answers beside the tags' numbers."""
LEAST_TEXTURE = 0.002
MOST_LIKENESS = 0.99


@dataclass(frozen=True)
class Calibration:
    """Weights of the softmax; unknown's own bias is 0."""

    tag_bias: float = param(-7.7159, "", "score of a tag that nothing speaks for", low=-1000.0, high=1000.0)
    tag_likeness: float = param(17.6513, "", "for the likeness l of tag and face, as atanh(l)", low=0.0, high=1000.0)
    tag_inliers: float = param(1.9655, "", "for n matches that agree, as log(1 + n)", low=0.0, high=1000.0)
    blank_bias: float = param(-12.6235, "", "score of a blank face of texture 1", low=-1000.0, high=1000.0)
    blank_texture: float = param(-6.6092, "", "for the texture t of the face, as log(t)", low=-1000.0, high=0.0)


@dataclass(frozen=True)
class Measures:
    """What an image says about one face.

    Attributes:
        tags: for each tag its likeness, -1 to 1, and matches that agree.
        texture: deviation of the face's grey without light and noise, for a mean of 1.
    """

    tags: Mapping[int, Tuple[float, int]]
    texture: float


def load_calibration(path: Optional[Path] = None) -> Calibration:
    """The weights of a file, by default those that are shipped.

    Raises:
        SceneError: the file cannot be read.
        ParamError: a weight is missing its name, out of range or not a number.
    """
    file = path or resource("config", "inspection", "tag_calibration.yaml")
    values = load_yaml(file)
    return build(Calibration, values if isinstance(values, dict) else {"(top level)": values}, str(file))


def features_of(measures: Measures) -> Dict[int, FloatArray]:
    """For each answer (5,) numbers, whose product with the weights, in their order, is its score."""
    texture = math.log(max(measures.texture, LEAST_TEXTURE))
    found = {
        tag: np.array([1.0, math.atanh(min(max(likeness, 0.0), MOST_LIKENESS)), math.log1p(inliers), 0.0, 0.0])
        for tag, (likeness, inliers) in measures.tags.items()
    }
    found[BLANK] = np.array([0.0, 0.0, 0.0, 1.0, texture])
    found[UNKNOWN] = np.zeros(5)
    return found


def probabilities(measures: Measures, calibration: Calibration) -> Dict[int, float]:
    """Probability of each tag, of BLANK and of UNKNOWN; they sum to 1."""
    c = calibration
    weights = np.array([c.tag_bias, c.tag_likeness, c.tag_inliers, c.blank_bias, c.blank_texture])
    scores = {answer: float(numbers @ weights) for answer, numbers in features_of(measures).items()}
    most = max(scores.values())
    powers = {answer: math.exp(score - most) for answer, score in scores.items()}
    whole = sum(powers.values())
    return {answer: power / whole for answer, power in powers.items()}
