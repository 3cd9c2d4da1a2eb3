"""The study of rendered views as trials, a piece of some views each, so that it can be stopped and gone on with."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

from yarm.experiments.study.runner import Progress, TrialKind, fingerprint, run_trials
from yarm.experiments.study.sources import files_of
from yarm.experiments.study.tag_views import ViewResult, drawn, looked
from yarm.resources import resource

VIEWS = "yarm.experiments.study.tag_views"
PIECE = 50
"""Views in one trial."""


@dataclass(frozen=True)
class Piece:
    """Some views that follow each other.

    Attributes:
        first: number of the first.
        count: how many.
        report_every: every so many-th view is also shown to the report's recognisers; 0 for none.
    """

    first: int
    count: int
    report_every: int

    @property
    def key(self) -> str:
        """Name of its file."""
        return f"views_{self.first}_{self.count}_{self.report_every}"


@dataclass(frozen=True)
class PieceResult:
    """What came of a piece.

    Attributes:
        spec: the piece.
        views: of each view, in order.
    """

    spec: Piece
    views: Tuple[ViewResult, ...]

    def to_json(self) -> Dict[str, Any]:
        """Plain values."""
        return {"spec": asdict(self.spec), "views": [view.to_json() for view in self.views]}

    @staticmethod
    def from_json(values: Mapping[str, Any]) -> PieceResult:
        """The same again."""
        return PieceResult(Piece(**values["spec"]), tuple(ViewResult.from_json(view) for view in values["views"]))


def pieces(first: int, count: int, report_every: int) -> List[Piece]:
    """All pieces of so many views."""
    starts = range(first, first + count, PIECE)
    return [Piece(start, min(PIECE, first + count - start), report_every) for start in starts]


def run_piece(piece: Piece) -> PieceResult:
    """Look at every view of a piece."""
    numbers = range(piece.first, piece.first + piece.count)
    asked = piece.report_every
    return PieceResult(piece, tuple(looked(drawn(n), asked > 0 and n % asked == 0) for n in numbers))


def code_of(piece: Piece) -> str:
    """Digest of what a piece depends on: how views are drawn and looked at, and the weights of the answers."""
    return _code()


@lru_cache(maxsize=1)
def _code() -> str:
    return fingerprint([*files_of([VIEWS]), resource("config", "inspection")])


PIECES: TrialKind[Piece, PieceResult] = TrialKind(run_piece, PieceResult.from_json, code_of)


def run_views(
    wanted: Sequence[Piece],
    folder: Path,
    scheduler: str = "",
    workers: int = 0,
    on_progress: Optional[Progress] = None,
) -> List[ViewResult]:
    """Every view's result, in order, of trials that ``run_trials`` runs or finds on disk.

    Raises:
        StudyError: pieces raised; all others are on disk.
    """
    done = run_trials(PIECES, wanted, folder, scheduler, workers, on_progress)
    return [view for piece in done for view in piece.views]
