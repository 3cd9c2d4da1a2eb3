"""How well a tag's picture lies on an upright face: by matched features, by shifting, by the library's ECC."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Mapping, Optional, Sequence, Tuple

import cv2
import numpy as np
import numpy.typing as npt

from yarm.geometry import FloatArray
from yarm.tags.face_view import MARGIN_PX, UPRIGHT_PX, Upright
from yarm.tags.features import Detector, Features
from yarm.tags.motifs import GreyImage
from yarm.tags.quads import mapped_corners

FloatImage = npt.NDArray[np.float32]
GATE_PX = 24.0
"""A tag's keypoint is looked for only so far from where the pose puts it, upright pixels (48 mm on the face)."""
FARTHEST_DESCRIPTOR = 270.0
"""SIFT descriptors farther apart are no match, whatever is near."""
RANSAC_PX = 2.5
LEAST_INLIERS = 8
SMOOTH_PX, FLATTEN_PX = 1.6, 20.0
"""Likeness compares what lies between these scales: finer is noise, coarser is light."""
COARSE = 4
"""The shift is searched, and the light taken, on pictures so many times smaller."""
ALIGNED = 2
"""A tag is aligned with a face on pictures so many times smaller: as near, in a third of the time."""
ECC_STEPS, ECC_EPSILON = 30, 1e-3


@dataclass(frozen=True, eq=False)
class Fit:
    """One tag laid on a face.

    Attributes:
        tag: its number.
        likeness: correlation of tag and face where it is seen, -1 to 1.
        inliers: matched keypoints that agree with one homography that agrees with the pose.
        matches: (m, 4) x, y in the tag's upright picture and x, y on the face, of the inliers.
        homography: (3, 3) from the tag's upright picture to the face with its margin; None when only shifted.
    """

    tag: int
    likeness: float
    inliers: int = 0
    matches: Optional[FloatArray] = None
    homography: Optional[FloatArray] = None


@dataclass(frozen=True, eq=False)
class Reference:
    """A tag as it is compared: features of its upright picture, flattened picture in two sizes."""

    features: Features
    flat: FloatImage
    coarse: FloatImage


def flattened(picture: GreyImage, mask: Optional[GreyImage] = None) -> FloatImage:
    """A picture without its noise and without slow changes of light; pixels where the mask is 0 count nothing."""
    seen = np.ones(picture.shape, np.float32) if mask is None else (mask > 0).astype(np.float32)
    grey = picture.astype(np.float32) * seen
    smooth, weight = (cv2.GaussianBlur(image, (0, 0), SMOOTH_PX) for image in (grey, seen))
    light, light_weight = (cv2.GaussianBlur(_smaller(image), (0, 0), FLATTEN_PX / COARSE) for image in (grey, seen))
    light = cv2.resize(_mean(light, light_weight), (picture.shape[1], picture.shape[0]), interpolation=cv2.INTER_LINEAR)
    flat: FloatImage = (_mean(smooth, weight) - light) * seen
    return flat


def _mean(total: FloatImage, weight: FloatImage) -> FloatImage:
    """Mean of the pixels that are seen, of weighted sums."""
    mean: FloatImage = total / np.maximum(weight, 1e-3)
    return mean


def reference_of(picture: GreyImage, detector: Detector) -> Reference:
    """What is kept of a tag's picture of any size."""
    small = cv2.resize(picture, UPRIGHT_PX, interpolation=cv2.INTER_AREA)
    flat = flattened(small)
    return Reference(detector.find(small), flat, _smaller(flat))


def fits(
    face: Upright, flat: FloatImage, references: Mapping[int, Reference], detector: Detector
) -> Tuple[List[Fit], int]:
    """Every tag laid on a face, which is given flattened too, where the pose puts it; and how many keypoints it has.

    The two tags with the most matches that agree, and the one whose shifted picture is likest, are aligned closely.
    """
    inner = cv2.erode(face.mask, np.ones((5, 5), np.uint8))
    scene = detector.find(face.picture, inner)
    coarse = _smaller(flat)
    shifted = {n: _shifted(coarse, face.share, reference) for n, reference in references.items()}
    gated = _gated_matches(scene, references)
    matched = {n: _by_matches(references[n], scene, gated.get(n)) for n in references}
    close = sorted(references, key=lambda n: -matched[n][0])[:2]
    likest = max(references, key=lambda n: shifted[n][0])
    found = []
    for number, reference in references.items():
        inliers, homography, pairs = matched[number]
        likeness = shifted[number][0]
        if homography is None and number == likest:
            homography = _by_correlation(flat, inner, reference, shifted[number][1])
        if homography is not None and (number in close or number == likest):
            likeness = max(likeness, likeness_of(flat, inner, reference, homography))
        found.append(Fit(number, likeness, inliers, pairs, homography))
    return found, len(scene)


def texture_within(picture: GreyImage, mask: GreyImage, flat: FloatImage, edge_px: int) -> float:
    """Deviation of a picture's grey, inside its edge, without light and noise (flattened), for a mean of 1."""
    inner = (slice(edge_px, -edge_px), slice(edge_px, -edge_px))
    seen = cv2.erode(mask, np.ones((7, 7), np.uint8))[inner] > 0
    if np.count_nonzero(seen) < 200:
        return 0.0
    return float(flat[inner][seen].std()) / max(1.0, float(picture[inner][seen].mean()))


def likeness_of(flat: FloatImage, mask: GreyImage, reference: Reference, homography: FloatArray) -> float:
    """Correlation of a flattened face with a tag mapped onto it, where both are."""
    size = (flat.shape[1], flat.shape[0])
    laid = cv2.warpPerspective(reference.flat, homography, size)
    cover = cv2.warpPerspective(np.full(reference.flat.shape, 255, np.uint8), homography, size)
    both = (mask > 0) & (cover > 127)
    if np.count_nonzero(both) < 400:
        return 0.0
    a, b = flat[both] - flat[both].mean(), laid[both] - laid[both].mean()
    scale = float(np.sqrt((a * a).sum() * (b * b).sum()))
    return float((a * b).sum()) / scale if scale > 0.0 else 0.0


def _smaller(image: FloatImage, times: int = COARSE) -> FloatImage:
    small: FloatImage = cv2.resize(image, None, fx=1 / times, fy=1 / times, interpolation=cv2.INTER_AREA)
    return small


def _shifted(coarse: FloatImage, share: float, reference: Reference) -> Tuple[float, Tuple[float, float]]:
    """Likeness at the best shift, and the shift of the tag's corner, upright pixels. Hidden parts of the face are 0."""
    scores = cv2.matchTemplate(coarse, reference.coarse, cv2.TM_CCORR_NORMED)
    _, best, _, (x, y) = cv2.minMaxLoc(scores)
    likeness = float(np.clip(best / np.sqrt(max(share, 0.05)), -1.0, 1.0))
    return likeness, (float(x * COARSE), float(y * COARSE))


def _gated_matches(scene: Features, references: Mapping[int, Reference]) -> Dict[int, FloatArray]:
    """For each tag (m, 2) indices of its keypoints and the scene's that match within the gate."""
    if len(scene) == 0:
        return {}
    numbers = [n for n in references if len(references[n].features)]
    points = np.concatenate([references[n].features.points for n in numbers]) + MARGIN_PX
    descriptors = np.concatenate([references[n].features.descriptors for n in numbers])
    owners = np.concatenate([np.full(len(references[n].features), n) for n in numbers])
    starts = np.concatenate([np.arange(len(references[n].features)) for n in numbers])
    near = (np.abs(points[:, None, 0].astype(np.float32) - scene.points[None, :, 0].astype(np.float32)) < GATE_PX) & (
        np.abs(points[:, None, 1].astype(np.float32) - scene.points[None, :, 1].astype(np.float32)) < GATE_PX
    )
    pairs = cv2.BFMatcher(cv2.NORM_L2).match(descriptors, scene.descriptors, near.astype(np.uint8))
    kept = [(p.queryIdx, p.trainIdx) for p in pairs if p.distance < FARTHEST_DESCRIPTOR]
    rows = np.array(kept, dtype=np.int64).reshape(-1, 2)
    found = {}
    for number in numbers:
        mine = rows[owners[rows[:, 0]] == number]
        found[number] = np.column_stack([starts[mine[:, 0]], mine[:, 1]])
    return found


def _by_matches(
    reference: Reference, scene: Features, pairs: Optional[FloatArray]
) -> Tuple[int, Optional[FloatArray], Optional[FloatArray]]:
    """Inliers, homography and matched points of a tag; none when the homography does not agree with the pose."""
    if pairs is None or len(pairs) < LEAST_INLIERS:
        return 0, None, None
    tag, seen = reference.features.points[pairs[:, 0]], scene.points[pairs[:, 1]]
    homography, kept = cv2.findHomography(tag, seen, cv2.RANSAC, RANSAC_PX)
    inliers = 0 if homography is None else int(kept.sum())
    if inliers < LEAST_INLIERS or not agrees_with_pose(homography):
        return 0, None, None
    return inliers, homography, np.column_stack([tag, seen])[kept[:, 0] > 0]


def agrees_with_pose(homography: FloatArray) -> bool:
    """Whether a homography puts the tag's corners where the pose does, within the gate."""
    expected = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * UPRIGHT_PX + MARGIN_PX
    corners = mapped_corners(homography, *UPRIGHT_PX)
    return bool(np.isfinite(corners).all() and np.linalg.norm(corners - expected, axis=1).max() < 1.5 * GATE_PX)


def _by_correlation(
    flat: FloatImage, mask: GreyImage, reference: Reference, shift: Tuple[float, float]
) -> Optional[FloatArray]:
    """Homography that the library's enhanced correlation (ECC) finds from a shift; None when it does not settle."""
    start = np.array([[1.0, 0.0, shift[0] / ALIGNED], [0.0, 1.0, shift[1] / ALIGNED]], np.float32)
    criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, ECC_STEPS, ECC_EPSILON)
    seen = cv2.resize(mask, None, fx=1 / ALIGNED, fy=1 / ALIGNED, interpolation=cv2.INTER_NEAREST)
    face, tag = _smaller(flat, ALIGNED), _smaller(reference.flat, ALIGNED)
    try:
        _, affine = cv2.findTransformECC(tag, face, start, cv2.MOTION_AFFINE, criteria, seen, 1)
    except cv2.error:  # the pictures have too little in common
        return None
    middle = 0.5 * (ALIGNED - 1)
    larger = np.array([[ALIGNED, 0.0, middle], [0.0, ALIGNED, middle], [0.0, 0.0, 1.0]])
    homography: FloatArray = larger @ np.vstack([affine, [0.0, 0.0, 1.0]]) @ np.linalg.inv(larger)
    return homography if agrees_with_pose(homography) else None


def best_first(found: Sequence[Fit]) -> List[Fit]:
    """Fits, the likest first; more inliers first among equals."""
    return sorted(found, key=lambda fit: (-fit.likeness, -fit.inliers))
