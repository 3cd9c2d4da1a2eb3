"""How sure a depth reading is."""

from __future__ import annotations

from typing import Any


def kinect_sigma(depth_m: Any) -> Any:
    """Standard deviation, metres, of a depth z along the optical axis, metres: of a number or of an array.

    sigma = 0.0012 + 0.0019 (z - 0.4)^2: the axial noise of the Kinect, as C. V. Nguyen, S. Izadi and D. Lovell measured
    it ("Modeling Kinect sensor noise for improved 3D reconstruction and tracking", 3DIMPVT 2012).
    """
    return 0.0012 + 0.0019 * (depth_m - 0.4) ** 2
