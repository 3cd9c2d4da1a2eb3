"""Probabilities of answers, and the file of weights."""

from __future__ import annotations

from pathlib import Path

import pytest

from yarm.params import ParamError
from yarm.tags.calibration import BLANK, UNKNOWN, Calibration, Measures, load_calibration, probabilities
from yarm.yaml_fields import SceneError


def test_the_shipped_file_holds_the_defaults() -> None:
    assert load_calibration() == Calibration()


def test_what_lies_well_is_named_what_is_bare_is_blank_the_rest_is_unknown() -> None:
    for measures, answer in (
        (Measures({1: (0.9, 40), 2: (0.2, 0)}, 0.3), 1),
        (Measures({1: (0.15, 0), 2: (0.2, 0)}, 0.3), UNKNOWN),
        (Measures({1: (0.15, 0), 2: (0.2, 0)}, 0.01), BLANK),
        (Measures({1: (1.0, 0), 2: (-1.0, 0)}, 0.0), 1),
    ):
        found = probabilities(measures, Calibration())
        assert sum(found.values()) == pytest.approx(1.0)
        assert max(found, key=lambda a: found[a]) == answer


def test_more_matches_and_more_likeness_are_more_probable() -> None:
    def of(likeness: float, inliers: int) -> float:
        return probabilities(Measures({1: (likeness, inliers)}, 0.3), Calibration())[1]

    assert of(0.3, 0) < of(0.4, 0) < of(0.4, 10)


@pytest.mark.parametrize(
    ("text", "error", "said"),
    [
        ("tag_bias: much\n", ParamError, "tag_bias = 'much'"),
        ("blank_texture: 3.0\n", ParamError, "-1000 to 0"),
        ("colour: 1.0\n", ParamError, "colour: unknown parameter"),
        ("- 1\n", ParamError, "top level"),
        ("a: [\n", SceneError, "not readable as YAML"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused(tmp_path: Path, text: str, error: type, said: str) -> None:
    file = tmp_path / "weights.yaml"
    file.write_text(text)
    with pytest.raises(error, match=said) as raised:
        load_calibration(file)
    assert str(file) in str(raised.value)
