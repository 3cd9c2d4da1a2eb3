"""Statistics against published and hand-computed values."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from yarm.experiments.statistics import Proportion, bootstrap_interval, interquartile_text, percentile, wilson_interval


@pytest.mark.parametrize(
    ("hits", "trials", "low", "high"),
    [
        (81, 263, 0.2553, 0.3662),  # Newcombe, Statistics in Medicine 17 (1998), table I
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0000, 0.1611),
        (1, 29, 0.0061, 0.1718),
        (30, 30, 0.8865, 1.0000),
    ],
)
def test_wilson_interval_has_the_published_values(hits: int, trials: int, low: float, high: float) -> None:
    assert wilson_interval(hits, trials) == pytest.approx((low, high), abs=5e-5)


@given(st.integers(0, 300), st.integers(1, 300))
def test_wilson_interval_holds_the_rate_and_stays_a_share(hits: int, trials: int) -> None:
    share = Proportion(min(hits, trials), trials)
    low, high = share.interval
    assert 0.0 <= low <= share.rate + 1e-12
    assert share.rate - 1e-12 <= high <= 1.0


def test_wilson_interval_covers_what_it_promises() -> None:
    rng = np.random.default_rng(7)
    truth, trials = 0.3, 30
    hits = rng.binomial(trials, truth, size=2000)
    covered = [low <= truth <= high for low, high in (wilson_interval(int(h), trials) for h in hits)]
    assert 0.93 <= np.mean(covered) <= 0.98


def test_no_trials_say_nothing() -> None:
    assert wilson_interval(0, 0) == (0.0, 1.0)
    assert math.isnan(Proportion(0, 0).rate)
    assert Proportion(0, 0).text() == "-"


def test_impossible_counts_are_refused() -> None:
    with pytest.raises(ValueError, match="hits 3 must be within 0 to 2"):
        Proportion(3, 2)


def test_percentiles_ignore_what_is_not_finite() -> None:
    assert percentile([1.0, math.nan, 3.0, math.inf], 50) == 2.0
    assert math.isnan(percentile([], 50))
    assert interquartile_text([4, 5, 6, 7, 8]) == "6 (5-7)"
    assert interquartile_text([]) == "-"


def test_a_bootstrap_interval_narrows_with_the_sample() -> None:
    def mean(values: Any) -> float:
        return float(values.mean())

    few, many = bootstrap_interval([0.0, 1.0] * 5, mean), bootstrap_interval([0.0, 1.0] * 200, mean)
    assert few[0] < many[0] < 0.5 < many[1] < few[1]
    assert bootstrap_interval([2.0] * 5, mean) == (2.0, 2.0) and math.isnan(bootstrap_interval([], mean)[0])
    assert many[1] - many[0] == pytest.approx(2 * 1.96 * 0.5 / math.sqrt(400), rel=0.2)
