"""Keypoints with descriptors, and good matches between two images; the library's detectors behind one face.

A match is good when the nearest descriptor is much nearer than the second nearest (D. Lowe, *Distinctive image
features from scale-invariant keypoints*, 2004). SURF is not in Debian's OpenCV, whose build leaves non-free parts out;
it is offered where the installed build has it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Dict, Optional, Tuple

import cv2
import numpy as np
import numpy.typing as npt

from yarm.geometry import FloatArray, IntArray
from yarm.tags.motifs import GreyImage

Descriptors = npt.NDArray[Any]
DETECTOR = "sift"
"""Whose features are matched unless another is asked for; ours was fitted with it and takes no other."""
HESSIAN_THRESHOLD = 300.0
"""Of SURF, as in the report."""
ORB_FEATURES = 1500
"""Most keypoints that ORB keeps."""
BITS = ("orb", "akaze")
"""Detectors whose descriptors are bits."""
MOST_KEPT = 32
"""Pictures of tags whose features are kept, a MB each: all of two detectors."""


class DetectorError(ValueError):
    """This detector is not known, or the installed OpenCV does not have it."""


@dataclass(frozen=True, eq=False)
class Features:
    """What a detector finds in an image.

    Attributes:
        points: (n, 2) pixels.
        descriptors: (n, d), float32, or uint8 where they are bits.
    """

    points: FloatArray
    descriptors: Descriptors

    def __len__(self) -> int:
        """Number of keypoints."""
        return len(self.points)


def available_detectors() -> Tuple[str, ...]:
    """Names that ``Detector`` takes with the installed OpenCV."""
    names = ["sift", "orb", "akaze"]
    return tuple([*names, "surf"] if _surf() is not None else names)


def detector_fault(name: str) -> str:
    """Why ``Detector`` does not take a name with the installed OpenCV; empty when it does."""
    known = available_detectors()
    return "" if name in known else f"the installed OpenCV has {', '.join(known)}"


class Detector:
    """Finds and matches features; one instance may be used for any number of images, by one thread at a time."""

    def __init__(self, name: str = DETECTOR) -> None:
        """Make a detector.

        Raises:
            DetectorError: no such detector here.
        """
        fault = detector_fault(name)
        if fault:
            raise DetectorError(f"detector {name!r}: {fault}")
        makers: Dict[str, Any] = {
            "sift": cv2.SIFT_create,
            "orb": lambda: cv2.ORB_create(ORB_FEATURES),
            "akaze": cv2.AKAZE_create,
            "surf": _surf,
        }
        self.name = name
        self._detector = makers[name]()

    def find(self, image: GreyImage, mask: Optional[GreyImage] = None) -> Features:
        """Keypoints of a grey image, where the mask, if any, is not 0."""
        keypoints, descriptors = self._detector.detectAndCompute(image, mask)
        if descriptors is None or not len(keypoints):
            width = self._detector.descriptorSize()
            kind = np.uint8 if self.name in BITS else np.float32
            return Features(np.zeros((0, 2)), np.zeros((0, width), kind))
        return Features(np.array([k.pt for k in keypoints], dtype=float), descriptors)

    def good_matches(self, tag: Features, scene: Features, ratio: float) -> IntArray:
        """(m, 2) indices of matching keypoints, of the tag and of the scene: nearest < ratio x second nearest."""
        if len(tag) == 0 or len(scene) < 2:
            return np.zeros((0, 2), np.int64)
        distances, nearest = self._two_nearest(tag, scene)
        good = np.flatnonzero(distances[:, 0] < ratio * distances[:, 1])
        return np.column_stack([good, nearest[good, 0]]).astype(np.int64)

    def _two_nearest(self, tag: Features, scene: Features) -> Tuple[FloatArray, IntArray]:
        """(n, 2) distances of the scene's two nearest descriptors to each of the tag's, and (n, 2) which they are.

        By brute force: exact, the same every time, and for some hundred descriptors quicker than FLANN's trees.
        """
        bits = self.name in BITS
        norm, kind = (cv2.NORM_HAMMING, cv2.CV_32S) if bits else (cv2.NORM_L2, cv2.CV_32F)
        distances, nearest = cv2.batchDistance(tag.descriptors, scene.descriptors, kind, normType=norm, K=2)
        return distances.astype(float), nearest


def features_of(name: str, picture: GreyImage) -> Features:
    """What a detector finds in a picture of a tag, (h, w) grey; found once for the same pixels. Not to be changed.

    Raises:
        DetectorError: no such detector here.
    """
    return _found(name, picture.shape, picture.tobytes())


@lru_cache(maxsize=MOST_KEPT)
def _found(name: str, shape: Tuple[int, ...], pixels: bytes) -> Features:
    return Detector(name).find(np.frombuffer(pixels, np.uint8).reshape(shape))


def _surf() -> Any:
    """SURF of the installed OpenCV, or None."""
    module = getattr(cv2, "xfeatures2d", None)
    if module is None or not hasattr(module, "SURF_create"):
        return None
    try:
        return module.SURF_create(HESSIAN_THRESHOLD)
    except cv2.error:  # the build has the name but not the code
        return None
