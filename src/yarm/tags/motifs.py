"""Kinds of pictures that a tag can show, drawn from a random generator: no two places of a picture are alike.

Every function draws on a grey canvas of ``SIZE_PX`` and takes how much detail to put in, 1 being the usual amount.
"""

from __future__ import annotations

import math
from typing import Callable, Dict, List, Tuple

import cv2
import numpy as np
import numpy.typing as npt

GreyImage = npt.NDArray[np.uint8]
SIZE_PX = (1000, 800)
"""Width and height of a picture; the face of a box has the same proportions."""
SHIFT = 4
"""Bits of a pixel's fraction in drawn coordinates."""
LETTERS = "ABCDEFGHJKLMNPQRSTUVWXYZabdefghkmnqrt2345679&?%"


class Canvas:
    """A grey picture that is drawn on."""

    def __init__(self, rng: np.random.Generator) -> None:
        """A background that fades from one grey to another in a random direction."""
        self.rng = rng
        width, height = SIZE_PX
        angle = rng.uniform(0.0, 2.0 * math.pi)
        x, y = np.meshgrid(np.linspace(-1.0, 1.0, width), np.linspace(-1.0, 1.0, height))
        slope = math.cos(angle) * x + math.sin(angle) * y
        self.image: GreyImage = np.clip(rng.uniform(130, 190) + 35.0 * slope, 0, 255).astype(np.uint8)

    def point(self, margin: float = 20.0) -> Tuple[float, float]:
        """A random place, pixels."""
        return self.rng.uniform(margin, SIZE_PX[0] - margin), self.rng.uniform(margin, SIZE_PX[1] - margin)

    def spread(self, n: int, jitter: float = 0.42) -> List[Tuple[float, float]]:
        """About n places that cover the whole picture, in random order."""
        columns = max(1, round(math.sqrt(n * SIZE_PX[0] / SIZE_PX[1])))
        rows = max(1, math.ceil(n / columns))
        places = [
            (
                (i + 0.5 + self.rng.uniform(-jitter, jitter)) * SIZE_PX[0] / columns,
                (j + 0.5 + self.rng.uniform(-jitter, jitter)) * SIZE_PX[1] / rows,
            )
            for i in range(columns)
            for j in range(rows)
        ]
        return [places[k] for k in self.rng.permutation(len(places))]

    def grey(self, dark: bool) -> int:
        """A random dark or light grey."""
        return int(self.rng.uniform(5, 85) if dark else self.rng.uniform(195, 252))

    def polygon(self, corners: npt.ArrayLike, grey: int) -> None:
        """Fill a polygon, corners (n, 2), pixels."""
        points = np.round(np.asarray(corners, dtype=float) * (1 << SHIFT)).astype(np.int32)
        cv2.fillPoly(self.image, [points], grey, cv2.LINE_AA, SHIFT)

    def line(self, points: npt.ArrayLike, grey: int, width: int) -> None:
        """Draw a line through points (n, 2), pixels."""
        rounded = np.round(np.asarray(points, dtype=float) * (1 << SHIFT)).astype(np.int32)
        cv2.polylines(self.image, [rounded], False, grey, width, cv2.LINE_AA, SHIFT)

    def ellipse(self, centre: Tuple[float, float], axes: Tuple[float, float], turn_deg: float, grey: int) -> None:
        """Fill an ellipse."""
        cv2.ellipse(self.image, (centre, (2 * axes[0], 2 * axes[1]), turn_deg), grey, -1, cv2.LINE_AA)

    def text(
        self, words: str, centre: Tuple[float, float], scale: float, turn_deg: float, grey: int, bold: int
    ) -> None:
        """Write words, turned about their middle."""
        font = cv2.FONT_HERSHEY_DUPLEX if self.rng.random() < 0.5 else cv2.FONT_HERSHEY_TRIPLEX
        (width, height), below = cv2.getTextSize(words, font, scale, bold)
        stencil = np.zeros((height + below + 8, width + 8), np.uint8)
        cv2.putText(stencil, words, (4, height + 4), font, scale, 255, bold, cv2.LINE_AA)
        turn = cv2.getRotationMatrix2D((width / 2 + 4, height / 2 + 4), turn_deg, 1.0)
        turn[:, 2] += np.array(centre) - (width / 2 + 4, height / 2 + 4)
        cover = cv2.warpAffine(stencil, turn, SIZE_PX).astype(np.float32)[..., None] / 255.0
        mixed = self.image[..., None] * (1.0 - cover) + grey * cover
        self.image = np.round(mixed[..., 0]).astype(np.uint8)


def mottle(rng: np.random.Generator, grain_px: float) -> npt.NDArray[np.float32]:
    """A smooth random pattern as large as a picture, mean 0, variance 1, its spots about as wide as the grain."""
    width, height = SIZE_PX
    coarse = rng.standard_normal((int(3 * height / grain_px) + 4, int(3 * width / grain_px) + 4)).astype(np.float32)
    coarse = cv2.GaussianBlur(coarse, (0, 0), 1.5)
    scaled: npt.NDArray[np.float32] = cv2.resize(coarse / coarse.std(), SIZE_PX, interpolation=cv2.INTER_CUBIC)
    return scaled


def blob(canvas: Canvas, centre: Tuple[float, float], radius: float, n: int) -> npt.NDArray[np.float64]:
    """Corners (n, 2) of a random star-shaped polygon about a place."""
    angles = np.sort(canvas.rng.uniform(0.0, 2.0 * math.pi, n))
    radii = radius * canvas.rng.uniform(0.45, 1.0, n)
    corners: npt.NDArray[np.float64] = np.stack(
        [centre[0] + radii * np.cos(angles), centre[1] + radii * np.sin(angles)], axis=1
    )
    return corners


def lettering(canvas: Canvas, detail: float) -> None:
    """A poster of words in many sizes."""
    rng = canvas.rng
    for i, place in enumerate(canvas.spread(round(30 * detail))):
        words = "".join(rng.choice(list(LETTERS), int(rng.integers(1, 4))))
        scale = rng.uniform(4.0, 7.0) if i % 3 else rng.uniform(9.0, 14.0)
        canvas.text(
            words, place, scale, rng.uniform(-35, 35), canvas.grey(rng.random() < 0.7), int(rng.integers(16, 34))
        )


def symbols(canvas: Canvas, detail: float) -> None:
    """Stars, rings, arrows and patches thrown on a table."""
    rng = canvas.rng
    for place in canvas.spread(round(30 * detail)):
        size, grey = rng.uniform(60, 130), canvas.grey(rng.random() < 0.5)
        other = 255 - grey
        kind = rng.integers(4)
        if kind == 0:
            canvas.polygon(blob(canvas, place, size, int(rng.integers(5, 11))), grey)
        elif kind == 1:
            canvas.ellipse(place, (size, size * rng.uniform(0.4, 0.9)), rng.uniform(0, 180), grey)
            canvas.polygon(blob(canvas, place, 0.6 * size, 5), other)
        elif kind == 2:
            canvas.polygon(blob(canvas, place, size, 7), grey)
            canvas.ellipse(place, (0.5 * size, 0.3 * size), rng.uniform(0, 180), other)
        else:
            canvas.line([place, canvas.point(), place], grey, int(rng.integers(4, 12)))
            canvas.polygon(blob(canvas, place, 0.7 * size, 3), grey)


def skyline(canvas: Canvas, detail: float) -> None:
    """Houses one behind the other, no two windows alike."""
    rng = canvas.rng
    for row, ground in enumerate((430.0, 600.0, 800.0)):
        left = -30.0
        while left < SIZE_PX[0]:
            width, height = rng.uniform(70, 190), rng.uniform(190, 400)
            wall = canvas.grey(rng.random() < 0.6)
            roof = ground - height
            canvas.polygon(
                [
                    (left, ground),
                    (left, roof),
                    (left + rng.uniform(0, width), roof - rng.uniform(0, 90)),
                    (left + width, roof + rng.uniform(-20, 50)),
                    (left + width, ground),
                ],
                wall,
            )
            for _ in range(int(rng.poisson(3 * detail))):
                place = (left + rng.uniform(0.1, 0.9) * width, roof + rng.uniform(0.08, 0.95) * height)
                canvas.polygon(
                    blob(canvas, place, rng.uniform(30, 60), 6), 255 - wall + int(rng.integers(-30, 30)) // 2
                )
            left += width * rng.uniform(0.8, 1.2)
        if row == 0:
            canvas.ellipse((rng.uniform(100, 900), rng.uniform(50, 130)), (55, 45), 0, 250)


def mountains(canvas: Canvas, detail: float) -> None:
    """Ridges with snow, a lake, trees and birds."""
    rng = canvas.rng
    for level, grey in zip((200, 360, 520, 680), (105, 215, 60, 160)):
        x = np.concatenate([[0.0], np.sort(rng.uniform(20, 980, 9)), [1000.0]])
        y = level + rng.uniform(-130, 90, len(x))
        canvas.polygon([(0, 800), *zip(x, y), (1000, 800)], grey)
        for place in zip(x[1:-1], y[1:-1]):
            canvas.polygon(blob(canvas, (place[0], place[1] + 25), rng.uniform(50, 90), 7), 255 - grey)
    for place in canvas.spread(round(30 * detail)):
        tall, grey = rng.uniform(60, 120), canvas.grey(rng.random() < 0.55)
        lean = rng.uniform(-0.5, 0.5, 3) * tall
        canvas.polygon(
            [
                (place[0] - 0.45 * tall, place[1]),
                (place[0] + lean[0], place[1] - tall * rng.uniform(1, 2)),
                (place[0] + 0.5 * tall, place[1] + lean[1]),
                (place[0] + lean[2], place[1] + 0.5 * tall),
            ],
            grey,
        )


def mosaic(canvas: Canvas, detail: float) -> None:
    """Stones of many greys, each nearest to its own place."""
    rng = canvas.rng
    seeds = np.array(canvas.spread(round(150 * detail), 0.6))
    division = cv2.Subdiv2D((-2000, -2000, 5000, 5000))
    division.insert([(float(x), float(y)) for x, y in seeds])
    facets, _ = division.getVoronoiFacetList([])
    for facet in facets:
        canvas.polygon(facet, canvas.grey(rng.random() < 0.5))
    for x, y in seeds[rng.random(len(seeds)) < 0.35]:
        canvas.ellipse((x, y), (rng.uniform(20, 40), rng.uniform(20, 40)), 0, int(rng.integers(0, 255)))


def machine(canvas: Canvas, detail: float) -> None:
    """Wheels with uneven teeth and spokes, driven by belts."""
    rng = canvas.rng
    places = canvas.spread(round(26 * detail))
    canvas.line(places, canvas.grey(True), 9)
    for place in places:
        radius, teeth = rng.uniform(80, 150), int(rng.integers(7, 17))
        grey = canvas.grey(rng.random() < 0.5)
        angles = np.repeat(np.sort(rng.uniform(0, 2 * math.pi, teeth)), 2) + np.tile([-0.06, 0.06], teeth)
        radii = radius * np.repeat(rng.uniform(0.7, 1.0, teeth), 2)
        canvas.polygon(np.stack([place[0] + radii * np.cos(angles), place[1] + radii * np.sin(angles)], 1), grey)
        for angle in rng.uniform(0, 2 * math.pi, int(rng.integers(1, 4))):
            hole = (place[0] + 0.5 * radius * math.cos(angle), place[1] + 0.5 * radius * math.sin(angle))
            canvas.ellipse(hole, (radius * rng.uniform(0.2, 0.35), radius * 0.2), math.degrees(angle), 255 - grey)


def branches(canvas: Canvas, detail: float) -> None:
    """Twigs that fork, with leaves, from more than one side."""
    rng = canvas.rng
    stems = [(canvas.point(), rng.uniform(0, 2 * math.pi), rng.uniform(110, 170), 0) for _ in range(round(7 * detail))]
    while stems:
        start, angle, length, depth = stems.pop()
        end = (start[0] + length * math.cos(angle), start[1] + length * math.sin(angle))
        canvas.line([start, end], 20 + 25 * depth, max(3, 16 - 4 * depth))
        if depth >= 3 or length < 35:
            grey = canvas.grey(rng.random() < 0.4)
            canvas.ellipse(end, (rng.uniform(30, 60), rng.uniform(18, 34)), rng.uniform(0, 180), grey)
            continue
        for turn in rng.uniform(-1.1, 1.1, int(rng.integers(2, 4))):
            stems.append((end, angle + turn, length * rng.uniform(0.6, 0.9), depth + 1))
    for place in canvas.spread(round(16 * detail)):
        canvas.polygon(blob(canvas, place, rng.uniform(40, 80), 7), canvas.grey(rng.random() < 0.5))


def streets(canvas: Canvas, detail: float) -> None:
    """A town's plan: blocks, crooked roads, a river, names."""
    rng = canvas.rng
    for place in canvas.spread(round(36 * detail)):
        canvas.polygon(blob(canvas, place, rng.uniform(60, 120), 5), canvas.grey(rng.random() < 0.5))
    for _ in range(round(9 * detail)):
        x = np.linspace(-20, 1020, 7)
        y = rng.uniform(0, 800) + np.cumsum(rng.uniform(-90, 90, 7))
        points = np.stack([x, y], 1) if rng.random() < 0.5 else np.stack([y * 1.2, x * 0.8], 1)
        canvas.line(points, 245, int(rng.integers(9, 20)))
        canvas.line(points, 60, 3)
    for place in canvas.spread(round(14 * detail)):
        word = "".join(rng.choice(list(LETTERS), int(rng.integers(3, 7))))
        canvas.text(word, place, rng.uniform(1.0, 2.0), rng.uniform(-60, 60), canvas.grey(rng.random() < 0.6), 4)


MOTIFS: Dict[str, Callable[[Canvas, float], None]] = {
    function.__name__: function
    for function in (lettering, symbols, skyline, mountains, mosaic, machine, branches, streets)
}
