"""Recognition as the report describes it: indicators of each tag in each image, votes, and the edge case.

SIFT takes the place of SURF unless another detector is asked for; every verdict says which was used.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from typing import Dict, List, Mapping, Optional, Sequence, Tuple

import cv2
import numpy as np

from yarm.geometry import FloatArray
from yarm.tags.features import DETECTOR, Detector, Features, features_of
from yarm.tags.motifs import GreyImage
from yarm.tags.quads import angles_deg, area, bottom_left_angle_deg, effective_area, is_tangled, mapped_corners

RATIO = 0.77
LEAST_GOOD = 4
RANSAC_PX = 3.0
LEAST_AREA_PX2 = 3000.0
LEAST_SHARE = 0.1
"""Good matches for each keypoint of the tag."""
LEAST_SIGHTINGS = 10
MOST_MINOR_VOTES = 7
CROP_TOP, CROP_BOTTOM = 0.08, 0.15
PROPORTION = 5.0 / 4.0
LEAST_IMAGE_PX = 60
UNSET = -69.42
FEW, NO_HOMOGRAPHY, NO_IMAGE, FOUND = -60.0, -50.0, -70.0, 0.0
"""Status of a tag in an image, the report's field [1]."""


class ImageError(ValueError):
    """An image cannot be used; the message says what it is and what was expected."""


@dataclass(frozen=True, eq=False)
class Sighting:
    """One tag in one image: the report's indicators.

    Attributes:
        tag: 1. number of the tag.
        box: 2. number of the box that is looked at.
        status: FOUND, FEW, NO_HOMOGRAPHY or NO_IMAGE.
        area_px2: 3. area of the outline.
        share: 4. good matches for each keypoint of the tag.
        corners: 5. (4, 2) pixels of the whole image.
        tangled: 6. whether opposite sides meet.
        keypoints: 7. keypoints in the image.
        good: 8. good matches.
        angles: 9. at the four corners, degrees.
        bottom_left_deg: 10. angle at the bottom left corner.
        effective_px2: 11. effective area.
        predicted_deg: 12. predicted angle.
        inliers: good matches that agree with the homography; no indicator of the report's, which never looks at them.
    """

    tag: int
    box: int
    status: float
    area_px2: float = UNSET
    share: float = UNSET
    corners: Optional[FloatArray] = None
    tangled: bool = False
    keypoints: int = 0
    good: int = 0
    angles: Tuple[float, float, float, float] = (UNSET, UNSET, UNSET, UNSET)
    bottom_left_deg: float = UNSET
    effective_px2: float = UNSET
    predicted_deg: float = UNSET
    inliers: int = 0

    @property
    def rejection(self) -> str:
        """Why it does not count; empty when it does."""
        if self.status != FOUND:
            return {FEW: "few matches", NO_HOMOGRAPHY: "no homography", NO_IMAGE: "no image"}[self.status]
        if self.tangled:
            return "tangled"
        if self.area_px2 <= LEAST_AREA_PX2:
            return "small"
        return "few matches for the tag's keypoints" if self.share < LEAST_SHARE else ""


@dataclass(frozen=True)
class ReportVerdict:
    """What the votes come to.

    Attributes:
        tag: number of the tag; 0 for blank.
        votes: surviving sightings of each tag.
        edge_case: whether it took the edge case's rules.
        detector: whose features were matched.
    """

    tag: int
    votes: Mapping[int, int]
    edge_case: bool
    detector: str


def cropped(image: GreyImage) -> Tuple[GreyImage, Tuple[int, int]]:
    """The part of an image that is looked at, in the face's proportions, and its first column and row.

    15 % are cut off below, 8 % above, and as much at both sides as makes it 5 to 4.

    Raises:
        ImageError: too small.
    """
    height, width = image.shape[:2]
    top, bottom = int(CROP_TOP * height), int((1.0 - CROP_BOTTOM) * height)
    wanted = int((bottom - top) * PROPORTION)
    if min(width, height) < LEAST_IMAGE_PX or wanted > width:
        raise ImageError(
            f"image of {width} x {height} px: expected at least {LEAST_IMAGE_PX} px each way and a width of "
            f"{max(LEAST_IMAGE_PX, wanted)}; use the camera's full image"
        )
    left = (width - wanted) // 2
    return image[top:bottom, left : left + wanted], (left, top)


def as_grey(image: GreyImage) -> GreyImage:
    """Grey of an image, (h, w) or (h, w, 3) red, green, blue.

    Raises:
        ImageError: another shape or type.
    """
    if image.dtype != np.uint8 or image.ndim not in (2, 3) or (image.ndim == 3 and image.shape[2] != 3):
        raise ImageError(f"image of shape {image.shape} and type {image.dtype}: expected 8 bits, grey or RGB")
    grey: GreyImage = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    return grey


def predicted_angle_deg(viewpoint_deg: float, heading_deg: float = 0.0) -> float:
    """The report's angle at the bottom left corner: 90 straight ahead, and so many more as the view is turned."""
    return 90.0 + viewpoint_deg + heading_deg


class ReportRecogniser:
    """The tags' features, found once, and what is made of an image with them."""

    def __init__(self, tags: Mapping[int, GreyImage], detector: str = DETECTOR, crop: bool = True) -> None:
        """Find the tags' features.

        Raises:
            DetectorError: the installed OpenCV does not have this detector.
        """
        self._detector = Detector(detector)
        self._crop = crop
        self.detector = detector
        self.sizes = {number: (picture.shape[1], picture.shape[0]) for number, picture in tags.items()}
        self.features: Dict[int, Features] = {n: features_of(detector, picture) for n, picture in tags.items()}

    def look(self, image: Optional[GreyImage], box: int = 0, predicted_deg: float = 90.0) -> List[Sighting]:
        """Every tag's sighting in an image, (h, w) grey or (h, w, 3) RGB; None for an image that did not come.

        Raises:
            ImageError: not an image, or too small to be cropped.
        """
        if image is None:
            return [Sighting(number, box, NO_IMAGE) for number in self.features]
        grey = as_grey(image)
        part, offset = cropped(grey) if self._crop else (grey, (0, 0))
        scene = self._detector.find(part)
        size = (grey.shape[1], grey.shape[0])
        return [self._sighting(number, box, predicted_deg, scene, offset, size) for number in self.features]

    def matched(self, image: GreyImage, number: int) -> FloatArray:
        """(m, 4) good matches of a tag: x, y in its picture and x, y in the image, pixels.

        Raises:
            ImageError: not an image, or too small to be cropped.
        """
        grey = as_grey(image)
        part, offset = cropped(grey) if self._crop else (grey, (0, 0))
        scene, tag = self._detector.find(part), self.features[number]
        pairs = self._detector.good_matches(tag, scene, RATIO)
        return np.column_stack([tag.points[pairs[:, 0]], scene.points[pairs[:, 1]] + offset])

    def _sighting(
        self,
        number: int,
        box: int,
        predicted_deg: float,
        scene: Features,
        offset: Tuple[int, int],
        size: Tuple[int, int],
    ) -> Sighting:
        tag = self.features[number]
        matches = self._detector.good_matches(tag, scene, RATIO)
        if len(matches) < LEAST_GOOD:
            return Sighting(number, box, FEW, keypoints=len(scene), good=len(matches))
        seen = scene.points[matches[:, 1]] + offset
        homography, agree = cv2.findHomography(tag.points[matches[:, 0]], seen, cv2.RANSAC, RANSAC_PX)
        if homography is None:
            return Sighting(number, box, NO_HOMOGRAPHY, keypoints=len(scene), good=len(matches))
        corners = mapped_corners(homography, *self.sizes[number])
        return Sighting(
            number,
            box,
            FOUND,
            area(corners),
            len(matches) / max(1, len(tag)),
            corners,
            is_tangled(corners),
            len(scene),
            len(matches),
            angles_deg(corners),
            bottom_left_angle_deg(corners),
            effective_area(corners, *size),
            predicted_deg,
            int(np.count_nonzero(agree)),
        )

    def verdict(self, sightings: Sequence[Sighting]) -> ReportVerdict:
        """The verdict on a box from all sightings of all its images."""
        survivors = [s for s in sightings if not s.rejection]
        votes = dict(sorted(Counter(s.tag for s in survivors).items()))
        if len(survivors) < LEAST_SIGHTINGS:
            return ReportVerdict(0, votes, False, self.detector)
        strong = [tag for tag, count in votes.items() if count > MOST_MINOR_VOTES]
        if len(strong) == 1:
            return ReportVerdict(strong[0], votes, False, self.detector)
        return ReportVerdict(edge_case(survivors, strong or list(votes)).together, votes, True, self.detector)


@dataclass(frozen=True)
class EdgeCase:
    """What the text's two rules choose, and both together.

    Attributes:
        by_angle: tag with the least summed difference from the predicted angle.
        by_area: tag with the largest summed effective area.
        together: the one that both choose; when they differ, both sums, scaled to 0 to 1 over the candidates, count
            alike.
    """

    by_angle: int
    by_area: int
    together: int


def edge_case(survivors: Sequence[Sighting], candidates: Sequence[int]) -> EdgeCase:
    """What the rules choose among candidates, by all sightings that survive."""
    differences, areas = [], []
    for tag in candidates:
        own = [s for s in survivors if s.tag == tag]
        gaps = [abs(s.bottom_left_deg - s.predicted_deg) for s in own]
        differences.append(sum(180.0 if math.isnan(gap) else gap for gap in gaps))
        areas.append(sum(s.effective_px2 for s in own))
    by_angle, by_area = int(np.argmin(differences)), int(np.argmax(areas))
    both = by_angle if by_angle == by_area else int(np.argmax(_scaled(areas) - _scaled(differences)))
    return EdgeCase(candidates[by_angle], candidates[by_area], candidates[both])


def _scaled(values: Sequence[float]) -> FloatArray:
    array = np.asarray(values, dtype=float)
    span = float(np.ptp(array))
    scaled: FloatArray = (array - array.min()) / span if span > 0.0 else np.zeros(len(array))
    return scaled
