"""Pictures of one look at a box: the image with outlines, and the tag beside the face drawn upright, with matches."""

from __future__ import annotations

from typing import Mapping, Optional, Tuple

import cv2
import numpy as np
import numpy.typing as npt

from yarm.geometry import FloatArray
from yarm.tags.face_view import MARGIN_PX, UPRIGHT_PX, FaceView, Upright, upright
from yarm.tags.motifs import GreyImage
from yarm.tags.pictures import size_at
from yarm.tags.recogniser import Look
from yarm.tags.report import ReportRecogniser, Sighting

ColourImage = npt.NDArray[np.uint8]
"""(h, w, 3) blue, green, red, as OpenCV writes files."""
PREDICTED, FOUND = (0, 140, 255), (60, 200, 60)
"""Colours of the outline where the pose puts it, and where the picture lies."""
MOST_LINES = 60
"""Matches that are drawn; more of them hide the pictures."""
SUBPIXEL = 4
"""Bits of a pixel that lines are drawn to."""
IN_MARGIN = np.array([MARGIN_PX, MARGIN_PX, 0.0, 0.0])
"""From a tag's picture to where it stands in a picture with a margin; the face has one already."""


def outline(to_image: FloatArray) -> FloatArray:
    """(4, 2) corners of an upright picture in the image, given (3, 3) from one to the other."""
    corners = np.array([[[0, 0], [1, 0], [1, 1], [0, 1]]], dtype=float) * UPRIGHT_PX
    mapped: FloatArray = cv2.perspectiveTransform(corners, to_image)[0]
    return mapped


def our_photo(image: GreyImage, view: FaceView, look: Look) -> ColourImage:
    """The image with the face's outline where the pose puts it, and where the likest tag was laid."""
    photo: ColourImage = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
    face = upright(image, view)
    if face is None:
        return photo
    shift = np.array([[1.0, 0.0, MARGIN_PX], [0.0, 1.0, MARGIN_PX], [0.0, 0.0, 1.0]])
    _draw(photo, outline(face.to_image @ shift), PREDICTED)
    if look.fits and look.fits[0].homography is not None:
        _draw(photo, outline(face.to_image @ look.fits[0].homography), FOUND)
    return photo


def our_pair(image: GreyImage, view: FaceView, look: Look, tags: Mapping[int, GreyImage]) -> Optional[ColourImage]:
    """The likest tag and, right of it, the face drawn upright, with the matches; None when no face was to be seen."""
    face: Optional[Upright] = upright(image, view)
    if face is None:
        return None
    reference = np.zeros_like(face.picture)
    inner = slice(MARGIN_PX, -MARGIN_PX)
    if not look.fits:
        return _side_by_side(reference, face.picture, np.zeros((0, 4)))
    best = look.fits[0]
    reference[inner, inner] = size_at(UPRIGHT_PX, tags[best.tag])
    matches = np.zeros((0, 4)) if best.matches is None else best.matches + IN_MARGIN
    return _side_by_side(reference, face.picture, matches)


def report_photo(image: GreyImage, sighting: Optional[Sighting]) -> ColourImage:
    """The image with the outline that the report's homography gives."""
    photo: ColourImage = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
    if sighting is not None and sighting.corners is not None:
        _draw(photo, sighting.corners, FOUND)
    return photo


def report_pair(image: GreyImage, sighting: Sighting, tags: Mapping[int, GreyImage]) -> Optional[ColourImage]:
    """A tag and, right of it, what lies inside its outline in the image, upright, with the good matches."""
    if sighting.corners is None or not np.isfinite(sighting.corners).all():
        return None
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32) * np.array(UPRIGHT_PX, np.float32)
    to_face = cv2.getPerspectiveTransform(sighting.corners.astype(np.float32), square)
    face = cv2.warpPerspective(image, to_face, UPRIGHT_PX)
    picture = tags[sighting.tag]
    matches = ReportRecogniser({sighting.tag: picture}).matched(image, sighting.tag)
    scale = np.array(UPRIGHT_PX) / (picture.shape[1], picture.shape[0])
    seen = cv2.perspectiveTransform(matches[None, :, 2:], to_face)[0] if len(matches) else matches[:, 2:]
    return _side_by_side(size_at(UPRIGHT_PX, picture), face, np.column_stack([matches[:, :2] * scale, seen]))


def _side_by_side(reference: GreyImage, face: GreyImage, matches: FloatArray) -> ColourImage:
    """Two pictures of one size, and lines from x, y in the first to x, y in the second."""
    both: ColourImage = cv2.cvtColor(np.hstack([reference, face]), cv2.COLOR_GRAY2BGR)
    shown = matches[:: max(1, -(-len(matches) // MOST_LINES))]
    width, height = reference.shape[1], reference.shape[0]
    for x, y, u, v in shown:
        if 0 <= u < width and 0 <= v < height:
            ends = [(round(a * 2**SUBPIXEL), round(b * 2**SUBPIXEL)) for a, b in ((x, y), (u + width, v))]
            cv2.line(both, ends[0], ends[1], FOUND, 1, cv2.LINE_AA, SUBPIXEL)
    return both


def _draw(photo: ColourImage, corners: FloatArray, colour: Tuple[int, int, int]) -> None:
    if np.isfinite(corners).all():
        points = np.round(np.clip(corners, -4000, 4000) * 2**SUBPIXEL).astype(np.int32)
        cv2.polylines(photo, [points], True, colour, 2, cv2.LINE_AA, SUBPIXEL)
