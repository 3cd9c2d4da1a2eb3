"""The sets of tag pictures: the fifteen of the task, a hard set, strangers, and faces without any picture.

All are drawn by ``yarm.tags.motifs`` from seeds, so that they are free of rights and can be made again:
``rosrun yarm make_tags``. The fifteen are shipped as ``tags/tag_01.png`` to ``tags/tag_15.png``.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, List, Mapping, Tuple

import cv2
import numpy as np

from yarm.resources import resource
from yarm.tags.motifs import MOTIFS, SIZE_PX, Canvas, GreyImage, mottle


class PictureError(ValueError):
    """A tag's picture cannot be used; the message says which file, what it is and what was expected."""


@dataclass(frozen=True)
class Design:
    """What a picture is drawn from.

    Attributes:
        motif: a key of ``MOTIFS``.
        seed: of its random generator.
        detail: how much is put in, 1 being a crowded picture.
        grain_px: width of the mottles it is painted with, pixels; the finer, the more keypoints.
    """

    motif: str
    seed: int
    detail: float = 0.5
    grain_px: float = 34.0


DESIGNS: Dict[int, Design] = {
    1: Design("mosaic", 101, 0.3, 66.0),
    2: Design("lettering", 233, 0.5, 38.0),
    3: Design("skyline", 307, 0.5, 31.0),
    4: Design("machine", 406, 0.45, 30.0),
    5: Design("mountains", 512, 0.35, 28.0),
    6: Design("branches", 606, 0.6, 30.0),
    7: Design("symbols", 705, 0.4, 34.0),
    8: Design("streets", 802, 0.35, 20.0),
    9: Design("streets", 909, 0.25, 40.0),
    10: Design("mosaic", 1001, 0.4, 27.0),
    11: Design("symbols", 1117, 0.3, 38.0),
    12: Design("machine", 1211, 0.3, 29.0),
    13: Design("skyline", 1318, 0.3, 23.0),
    14: Design("branches", 1416, 0.35, 36.0),
    15: Design("mountains", 1610, 0.2, 23.0),
}
"""The tags of the task by number."""
LEAST_PX = (50, 40)
"""Least width and height of a tag's picture."""
TWIN_PX, TWIN = (50, 40), 0.97
"""Two pictures are one when, scaled down to this size, they correlate by more than this, whatever their contrast."""
CONTRAST = 0.4
"""Share of the shapes' contrast that is left beside their mottles."""
STRANGERS = 10
"""Pictures that are in no set."""
BLANKS = ("white", "cardboard", "shadow", "frame")
"""Faces without a picture: plain white, brown cardboard with grain, a shadow's edge, a printed frame."""


def draw(design: Design) -> GreyImage:
    """The picture of a design, (800, 1000), 8-bit grey.

    Shapes of plain grey look alike to a feature detector wherever they stand. So light and dark parts are painted with
    two different mottled patterns, which makes every place unlike every other, and the greys are rounded to steps of 8,
    which makes the file small.
    """
    rng = np.random.default_rng(design.seed)
    canvas = Canvas(rng)
    MOTIFS[design.motif](canvas, design.detail)
    light = canvas.image > 128
    painted = 128.0 + CONTRAST * (canvas.image.astype(np.float32) - 128.0)
    for grain_px, strength in ((design.grain_px, 42.0), (2.0 * design.grain_px, 38.0)):
        painted += strength * np.where(light, mottle(rng, grain_px), mottle(rng, grain_px))
    image: GreyImage = np.clip(8.0 * np.round(painted / 8.0), 0, 255).astype(np.uint8)
    return image


def hard_set() -> Dict[int, GreyImage]:
    """Nine tags that are easy to mistake.

    1 and 2, 3 and 4, 5 and 6 are pairs that share their left half, 7 and 8 are low in contrast, 9 has few keypoints.
    """
    found: Dict[int, GreyImage] = {}
    for pair, motif in enumerate(("symbols", "streets", "mosaic")):
        first, second = draw(Design(motif, 2000 + 2 * pair)), draw(Design(motif, 2001 + 2 * pair))
        second[:, : SIZE_PX[0] // 2] = first[:, : SIZE_PX[0] // 2]
        found[2 * pair + 1], found[2 * pair + 2] = first, second
    for number, motif in ((7, "skyline"), (8, "lettering")):
        full = draw(Design(motif, 2010 + number)).astype(float)
        found[number] = np.round(128.0 + 0.2 * (full - 128.0)).astype(np.uint8)
    found[9] = draw(Design("branches", 2020, 0.3, 120.0))
    return found


def stranger(number: int) -> GreyImage:
    """Picture 0 to 9 of those that are in no set."""
    return draw(Design(list(MOTIFS)[number % len(MOTIFS)], 3000 + number, 0.4, 24.0 + 3.0 * number))


def blank(kind: str, seed: int = 0) -> GreyImage:
    """A face without a picture.

    Raises:
        ValueError: no such kind; ``BLANKS`` are known.
    """
    width, height = SIZE_PX
    rng = np.random.default_rng(seed)
    if kind == "white":
        return np.full((height, width), 240, np.uint8)
    if kind == "cardboard":
        fibres = rng.standard_normal((height, width)).astype(np.float32)
        grain = cv2.GaussianBlur(fibres, (0, 0), sigmaX=12.0, sigmaY=1.2)
        fibrous: GreyImage = np.clip(140.0 + 5.0 * grain / grain.std(), 0, 255).astype(np.uint8)
        return fibrous
    if kind == "shadow":
        bent = np.linspace(rng.uniform(0.2, 0.8), rng.uniform(0.2, 0.8), height)[:, None] * width
        edge = 1.0 / (1.0 + np.exp(-(np.arange(width)[None, :] - bent) / 15.0))
        shaded: GreyImage = np.round(110.0 + 120.0 * edge).astype(np.uint8)
        return shaded
    if kind == "frame":
        face = np.full((height, width), 235, np.uint8)
        cv2.rectangle(face, (40, 40), (width - 41, height - 41), 40, 14)
        return face
    raise ValueError(f"blank {kind!r}: expected one of {', '.join(BLANKS)}")


def file_name(number: int) -> str:
    """Name of the file of a tag of the task."""
    return f"tag_{number:02d}.png"


def write_pictures(folder: Path) -> List[Path]:
    """Draw the fifteen tags into a folder, which is made when missing; the files.

    Raises:
        OSError: a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for number, design in DESIGNS.items():
        path = folder / file_name(number)
        if not cv2.imwrite(str(path), draw(design), [cv2.IMWRITE_PNG_COMPRESSION, 9]):
            raise OSError(f"{path} cannot be written")
        paths.append(path)
    return paths


def contact_sheet(pictures: Dict[str, GreyImage], columns: int = 5, width_px: int = 200) -> GreyImage:
    """Pictures side by side with their names, for documents."""
    height_px = width_px * SIZE_PX[1] // SIZE_PX[0]
    rows: List[GreyImage] = []
    tiles: List[GreyImage] = []
    for name, picture in pictures.items():
        small = size_at((width_px, height_px), picture)
        tile = cv2.copyMakeBorder(small, 22, 6, 6, 6, cv2.BORDER_CONSTANT, value=255)
        cv2.putText(tile, name, (8, 16), cv2.FONT_HERSHEY_SIMPLEX, 0.5, 0, 1, cv2.LINE_AA)
        tiles.append(tile)
    while len(tiles) % columns:
        tiles.append(np.full_like(tiles[0], 255))
    for start in range(0, len(tiles), columns):
        rows.append(np.hstack(tiles[start : start + columns]))
    sheet: GreyImage = np.vstack(rows)
    return sheet


def size_at(size_px: Tuple[int, int], picture: GreyImage) -> GreyImage:
    """A picture scaled down to a width and height in pixels."""
    scaled: GreyImage = cv2.resize(picture, size_px, interpolation=cv2.INTER_AREA)
    return scaled


def read_picture(path: Path) -> GreyImage:
    """A picture of a tag from a file, any kind that OpenCV reads.

    Raises:
        PictureError: no such file, no picture, in colour, or too small.
    """
    if not os.path.isfile(path):  # Path.is_file() raises where a name is too long to be one
        raise PictureError(f"{path}: no such file; a tag needs a picture")
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if image is None or image.dtype != np.uint8:
        raise PictureError(f"{path}: expected an 8-bit picture (PNG, JPEG, ...)")
    if image.ndim == 3:
        if image.shape[2] != 3 or np.ptp(image, axis=2).max() > 0:
            raise PictureError(f"{path}: has {image.shape[2]} channels that differ; expected a grey picture")
        image = np.ascontiguousarray(image[..., 0])
    height, width = image.shape
    if width < LEAST_PX[0] or height < LEAST_PX[1]:
        raise PictureError(f"{path}: {width} x {height} px; expected at least {LEAST_PX[0]} x {LEAST_PX[1]}")
    grey: GreyImage = image
    return grey


def twins(pictures: Mapping[int, GreyImage]) -> List[Tuple[int, int]]:
    """Pairs of numbers, the smaller first, whose pictures are the same but for their size, light and contrast."""
    numbers = sorted(pictures)
    rows = np.array([size_at(TWIN_PX, pictures[number]).ravel() for number in numbers], dtype=float)
    rows -= rows.mean(axis=1, keepdims=True)
    rows /= np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-9)
    alike = rows @ rows.T > TWIN
    plain = ~rows.any(axis=1)
    alike |= plain[:, None] & plain[None]
    return [(numbers[i], numbers[j]) for i, j in np.argwhere(np.triu(alike, 1))]


def shipped_pictures() -> Dict[int, GreyImage]:
    """The fifteen tags as they are shipped, by number.

    Raises:
        PictureError: a file is missing or cannot be used.
    """
    return {number: read_picture(resource("tags", file_name(number))) for number in DESIGNS}
