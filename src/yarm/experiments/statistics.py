"""The few statistics the reports need: proportions with Wilson intervals, small samples' percentiles, the bootstrap."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray

Z_95 = 1.959963984540054
"""Two-sided 95 % quantile of the normal distribution."""


@dataclass(frozen=True)
class Proportion:
    """A share of trials with its 95 % Wilson score interval.

    Attributes:
        hits: trials in which it happened.
        trials: all trials.
    """

    hits: int
    trials: int

    def __post_init__(self) -> None:
        """Refuse counts that are no share.

        Raises:
            ValueError: hits outside 0 .. trials.
        """
        if not 0 <= self.hits <= self.trials:
            raise ValueError(f"hits {self.hits} must be within 0 to {self.trials} trials")

    @property
    def rate(self) -> float:
        """Share of the trials; NaN without trials."""
        return self.hits / self.trials if self.trials else math.nan

    @property
    def interval(self) -> Tuple[float, float]:
        """Wilson score interval at 95 %; (0, 1) without trials."""
        return wilson_interval(self.hits, self.trials)

    def text(self) -> str:
        """For tables: "27 % (14-44)", rate and interval in per cent."""
        if not self.trials:
            return "-"
        low, high = self.interval
        return f"{100 * self.rate:.0f} % ({100 * low:.0f}-{100 * high:.0f})"


def wilson_interval(hits: int, trials: int, z: float = Z_95) -> Tuple[float, float]:
    """Wilson score interval of a proportion (E. B. Wilson, JASA 22, 1927).

    Args:
        hits: trials in which it happened.
        trials: all trials; 0 gives (0, 1).
        z: quantile of the normal distribution.

    Returns:
        Lower and upper bound, within [0, 1].
    """
    if trials == 0:
        return 0.0, 1.0
    share = hits / trials
    weight = 1.0 + z * z / trials
    middle = (share + z * z / (2 * trials)) / weight
    half = z * math.sqrt(share * (1 - share) / trials + z * z / (4 * trials * trials)) / weight
    return max(0.0, middle - half), min(1.0, middle + half)


def percentile(values: Sequence[float], percent: float) -> float:
    """Percentile (linear interpolation) of the finite values; NaN when there is none."""
    finite = [v for v in values if math.isfinite(v)]
    return float(np.percentile(finite, percent)) if finite else math.nan


def interquartile_text(values: Sequence[float], digits: int = 0) -> str:
    """For tables: "11 (10-13)", median and quartiles of the finite values; "-" when there is none."""
    middle = percentile(values, 50)
    if math.isnan(middle):
        return "-"
    low, high = percentile(values, 25), percentile(values, 75)
    return f"{middle:.{digits}f} ({low:.{digits}f}-{high:.{digits}f})"


def bootstrap_interval(
    values: Sequence[float], statistic: Callable[[FloatArray], float], rounds: int = 2000, seed: int = 0
) -> Tuple[float, float]:
    """Percentile bootstrap interval at 95 % (B. Efron, Annals of Statistics 7, 1979).

    Args:
        values: the sample; for pairs, a value a pair.
        statistic: of a sample, such as numpy.median.
        rounds: samples drawn from the sample.
        seed: of the draws.

    Returns:
        Lower and upper bound; NaN both for an empty sample.
    """
    sample: FloatArray = np.asarray(values, dtype=float)
    if not len(sample):
        return math.nan, math.nan
    draws = np.random.default_rng(seed).integers(len(sample), size=(rounds, len(sample)))
    found = np.sort([statistic(sample[draw]) for draw in draws])
    low, high = math.floor(0.025 * (rounds - 1)), math.ceil(0.975 * (rounds - 1))
    return float(found[low]), float(found[high])
