"""Fits the recogniser's weights to rendered views, and says how well probabilities agree with what came true."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import List, Sequence, Tuple

import numpy as np
from scipy.optimize import minimize

from yarm.experiments.study.tag_views import ViewResult, drawn
from yarm.geometry import FloatArray
from yarm.tags.calibration import Calibration, features_of
from yarm.tags.chance import LookChance, chance_features
from yarm.tags.evidence import ACCEPTING

FIRST_TRAINING_VIEW = 1_000_000
"""Views from this number on are for fitting, those below for judging."""
RIDGE = 0.02
"""Weight of the squared weights in the fit, which keeps them finite where the answers can be told apart completely."""


@dataclass(frozen=True)
class Bin:
    """Answers given with a probability in a range.

    Attributes:
        low: least probability.
        high: greatest probability.
        mean: mean probability of those in it.
        right: share of them that were right.
        count: how many.
    """

    low: float
    high: float
    mean: float
    right: float
    count: int


def fitted(results: Sequence[ViewResult]) -> Calibration:
    """The weights that make the true answers most probable, with a ridge.

    Raises:
        ValueError: no view could be judged.
    """
    tables, truths = [], []
    for result in results:
        if result.measures is None:
            continue
        features = features_of(result.measures)
        if result.truth in features:
            answers = list(features)
            tables.append(np.array([features[answer] for answer in answers]))
            truths.append(answers.index(result.truth))
    if not tables:
        raise ValueError(f"none of {len(results)} views could be judged: nothing to fit")
    stack, right = np.array(tables), np.array(truths)

    def loss(weights: FloatArray) -> Tuple[float, FloatArray]:
        scores = stack @ weights
        scores -= scores.max(1, keepdims=True)
        powers = np.exp(scores)
        shares = powers / powers.sum(1, keepdims=True)
        rows = np.arange(len(right))
        error = -np.log(np.maximum(shares[rows, right], 1e-300)).sum() + RIDGE * float(weights @ weights)
        shares[rows, right] -= 1.0
        return float(error), np.einsum("nk,nkf->f", shares, stack) + 2.0 * RIDGE * weights

    start = np.array(list(asdict(Calibration()).values()))
    bounds = [(f.metadata["param"].low, f.metadata["param"].high) for f in fields(Calibration)]
    best = minimize(loss, start, jac=True, bounds=bounds, method="L-BFGS-B")
    return Calibration(*(round(float(weight), 4) for weight in best.x))


def fitted_chance(results: Sequence[ViewResult]) -> LookChance:
    """Weights of the chance that a look at a tag is right and final.

    Raises:
        ValueError: no view shows a tag.
    """
    rows, hits = [], []
    for result in (r for r in results if r.truth > 0):
        view = drawn(result.number)
        rows.append(chance_features(result.visible, view.angle_deg, view.distance_m))
        hits.append(result.answer == result.truth and result.probability >= ACCEPTING)
    if not rows:
        raise ValueError(f"none of {len(results)} views shows a tag: nothing to fit")
    table, signs = np.array(rows), np.where(hits, 1.0, -1.0)

    def loss(weights: FloatArray) -> float:
        return float(np.logaddexp(0.0, -signs * (table @ weights)).sum() + RIDGE * weights @ weights)

    best = minimize(loss, np.zeros(table.shape[1]), method="BFGS")
    return LookChance(*(round(float(weight), 3) for weight in best.x))


def write_calibration(calibration: Calibration, path: Path) -> None:
    """Write the weights as the recogniser reads them."""
    path.write_text("".join(f"{name}: {value}\n" for name, value in asdict(calibration).items()))


def bins_of(results: Sequence[ViewResult], edges: Sequence[float]) -> List[Bin]:
    """Answers in ranges of their probability; ranges without one are left out."""
    answered = [r for r in results if r.answer is not None]
    found = []
    for low, high in zip(edges, edges[1:]):
        inside = [r for r in answered if low <= r.probability < high or (high == edges[-1] and r.probability == high)]
        if inside:
            mean = float(np.mean([r.probability for r in inside]))
            right = float(np.mean([r.answer == r.truth for r in inside]))
            found.append(Bin(low, high, mean, right, len(inside)))
    return found


def expected_error(bins: Sequence[Bin]) -> float:
    """Mean difference of probability and share that was right, weighted by the number of answers."""
    count = sum(b.count for b in bins)
    return sum(b.count * abs(b.mean - b.right) for b in bins) / count if count else 0.0
