"""What can be chosen about planning, and what is refused."""

from __future__ import annotations

from typing import Any

import pytest

from yarm.params import ParamError, build
from yarm.planning.model.params import PlannerParams


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("particles", 0),
        ("particles", "many"),
        ("narrow_factor", 0.5),
        ("turns_deg", (0.0, 181.0)),
        ("turn_deg_per_cell", 0.0),
        ("keep_gain", 1.1),
        ("least_step_cells", 0),
    ],
)
def test_what_is_out_of_range_is_named(name: str, value: Any) -> None:
    with pytest.raises(ParamError, match=f"{name} = "):
        build(PlannerParams, {name: value}, "options")
