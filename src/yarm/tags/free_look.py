"""Tags anywhere in a picture of which nothing else is known: no pose, no box. By matches that agree on a homography.

What is found is drawn upright through its homography and judged as ``yarm.tags.recogniser`` judges a face. That nothing
is found says nothing: a blank face is only told where a face must be.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Dict, List, Mapping, Optional, Tuple

import cv2
import numpy as np

from yarm.geometry import FloatArray
from yarm.params import param
from yarm.tags.alignment import Reference, fits, flattened, reference_of
from yarm.tags.calibration import Calibration, Measures, load_calibration, probabilities
from yarm.tags.face_view import MARGIN_PX, UPRIGHT_PX, Upright
from yarm.tags.features import DETECTOR, Detector, Features, detector_fault
from yarm.tags.motifs import GreyImage
from yarm.tags.quads import area, is_tangled, mapped_corners
from yarm.tags.recogniser import texture_of
from yarm.tags.report import cropped

LEAST_AREA_PX2 = 400.0
WIDEST_PX = 400
"""Tags are made this wide before their features are looked for: about as large as they are seen."""


@dataclass(frozen=True)
class FreeSettings:
    """How a picture is searched."""

    detector: str = param(DETECTOR, "", "whose features are matched: sift, orb, akaze; surf where the build has it")
    ratio: float = param(0.77, "", "a match is good when nearest < ratio x second nearest", low=0.1, high=1.0)
    min_inliers: int = param(12, "", "matches that agree on a homography, at least", low=4, high=10000)
    ransac_px: float = param(3.0, "px", "a match agrees when it is this near", low=0.1, high=50.0)
    crop: bool = param(False, "", "look at the middle of the picture only, as the report does")

    @property
    def faults(self) -> Tuple[str, ...]:
        """What no range of a single parameter tells."""
        fault = detector_fault(self.detector)
        return (f"detector = {self.detector!r}: {fault}",) if fault else ()


@dataclass(frozen=True, eq=False)
class Sight:
    """A tag in a picture.

    Attributes:
        tag: its number.
        size: width and height of its picture, pixels.
        homography: (3, 3) from pixels of the tag's picture to the picture's.
        inliers: matches that agree on it.
    """

    tag: int
    size: Tuple[int, int]
    homography: FloatArray
    inliers: int

    @property
    def corners(self) -> FloatArray:
        """(4, 2) top left, top right, bottom right, bottom left of the tag, in the picture."""
        return mapped_corners(self.homography, *self.size)


@dataclass(frozen=True, eq=False)
class FreeLook:
    """What one picture shows.

    Attributes:
        sights: the tags that were found, that with the most matches first.
        probabilities: of each tag, BLANK and UNKNOWN, for the first of them; empty when none was found.
        reason: why none was found; empty otherwise.
    """

    sights: Tuple[Sight, ...] = ()
    probabilities: Mapping[int, float] = field(default_factory=dict)
    reason: str = ""


class FreeRecogniser:
    """A set of tags that can grow and shrink; for one thread at a time."""

    def __init__(self, settings: FreeSettings, calibration: Optional[Calibration] = None) -> None:
        """No tags yet.

        Raises:
            DetectorError: the installed OpenCV does not have this detector.
        """
        self._settings = settings
        self._detector = Detector(settings.detector)
        self._judge = Detector("sift")
        self._calibration = calibration or load_calibration()
        self._sizes: Dict[int, Tuple[int, int]] = {}
        self._references: Dict[int, Reference] = {}
        self._features: Dict[int, Features] = {}

    @property
    def tags(self) -> Tuple[int, ...]:
        """Numbers of the tags that are looked for."""
        return tuple(sorted(self._features))

    def add(self, number: int, picture: GreyImage) -> None:
        """Look for this tag as well; one of the same number is replaced.

        Raises:
            ValueError: a number below 1, or too few keypoints ever to be found.
        """
        if number < 1:
            raise ValueError(f"tag {number}: numbers begin at 1")
        scale = min(1.0, WIDEST_PX / picture.shape[1])
        small = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        found = self._detector.find(small)
        if len(found) < self._settings.min_inliers:
            least = self._settings.min_inliers
            raise ValueError(f"tag {number}: {len(found)} keypoints, at least {least} (min_inliers) are needed")
        self._sizes[number] = (picture.shape[1], picture.shape[0])
        self._references[number] = reference_of(picture, self._judge)
        self._features[number] = Features((found.points + 0.5) / scale - 0.5, found.descriptors)

    def remove(self, number: int) -> bool:
        """Look for this tag no longer; false when it is not known."""
        self._references.pop(number, None)
        return self._features.pop(number, None) is not None

    def look(self, grey: GreyImage) -> FreeLook:
        """What a picture, (h, w) grey, shows.

        Raises:
            ImageError: too small to be cropped.
        """
        if not self._features:
            return FreeLook(reason="no tags are loaded; use ~load_tags or ~add_tag")
        part, offset = cropped(grey) if self._settings.crop else (grey, (0, 0))
        scene = self._detector.find(part)
        scene = Features(scene.points + offset, scene.descriptors)
        found = [sight for number in self.tags for sight in self._sights(number, scene)]
        if not found:
            least = self._settings.min_inliers
            return FreeLook(reason=f"of {len(scene)} keypoints no {least} agree with a tag (min_inliers)")
        found.sort(key=lambda sight: (-sight.inliers, sight.tag))
        return FreeLook(tuple(found), self._judged(grey, found[0]))

    def _sights(self, number: int, scene: Features) -> List[Sight]:
        """The tag's one sight, or none."""
        tag = self._features[number]
        matches = self._detector.good_matches(tag, scene, self._settings.ratio)
        if len(matches) < self._settings.min_inliers:
            return []
        homography, kept = cv2.findHomography(
            tag.points[matches[:, 0]], scene.points[matches[:, 1]], cv2.RANSAC, self._settings.ransac_px
        )
        if homography is None or int(kept.sum()) < self._settings.min_inliers:
            return []
        sight = Sight(number, self._sizes[number], homography, int(kept.sum()))
        fine = np.isfinite(sight.corners).all() and not is_tangled(sight.corners)
        return [sight] if fine and area(sight.corners) >= LEAST_AREA_PX2 else []

    def _judged(self, grey: GreyImage, sight: Sight) -> Dict[int, float]:
        """Probability of every answer for what lies where this sight is."""
        face = _upright(grey, sight)
        flat = flattened(face.picture, face.mask)
        laid, _ = fits(face, flat, self._references, self._judge)
        measures = Measures({fit.tag: (fit.likeness, fit.inliers) for fit in laid}, texture_of(face, flat))
        return probabilities(measures, self._calibration)


def _upright(grey: GreyImage, sight: Sight) -> Upright:
    """What lies where a tag was found, drawn upright with its margin."""
    scale_x, scale_y = sight.size[0] / UPRIGHT_PX[0], sight.size[1] / UPRIGHT_PX[1]
    to_tag = np.array(
        [
            [scale_x, 0.0, (0.5 - MARGIN_PX) * scale_x - 0.5],
            [0.0, scale_y, (0.5 - MARGIN_PX) * scale_y - 0.5],
            [0.0, 0.0, 1.0],
        ]
    )
    to_image: FloatArray = sight.homography @ to_tag
    size = (UPRIGHT_PX[0] + 2 * MARGIN_PX, UPRIGHT_PX[1] + 2 * MARGIN_PX)
    inverse = cv2.WARP_INVERSE_MAP
    picture = cv2.warpPerspective(grey, to_image, size, flags=cv2.INTER_LINEAR | inverse)
    seen = np.full(grey.shape, 255, np.uint8)
    mask = cv2.warpPerspective(seen, to_image, size, flags=cv2.INTER_NEAREST | inverse)
    inner = mask[MARGIN_PX:-MARGIN_PX, MARGIN_PX:-MARGIN_PX]
    return Upright(picture, mask, float(np.count_nonzero(inner)) / inner.size, 1.0, to_image)


def qt_homography(homography: FloatArray) -> Tuple[float, ...]:
    """The nine numbers as find_object_2d sends them: row by row of Qt's transform, which multiplies from the right."""
    return tuple(float(value) for value in (homography / homography[2, 2]).T.ravel())
