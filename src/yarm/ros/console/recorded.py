"""A recorded run for the page: found in its folder or file, served without a ROS master, or exported as one file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from yarm.console.export import offline_page, pictures_of
from yarm.console.film import Film, FilmError
from yarm.console.results import FILM, SUMMARY, read_summary
from yarm.resources import resource
from yarm.ros.console.bags import film_of_bag

BAG = "run.bag"
PERIOD_S = 0.2
"""Between two pictures of a film that is made of a bag, s of recorded time."""


@dataclass(frozen=True)
class Recorded:
    """A film and the folder of its run."""

    film: Film
    folder: Path

    @property
    def results(self) -> Path:
        """Folder of results that the run is one of: <results>/<case>/<seed>/."""
        return self.folder.parents[1] if len(self.folder.parents) > 1 else self.folder

    def page(self) -> str:
        """The run as one HTML file.

        Raises:
            ResultError: its summary cannot be read.
            OSError: its pictures cannot be read.
        """
        summary = self.folder / SUMMARY
        words = read_summary(summary) if summary.is_file() else {}
        return offline_page(resource("web"), self.film, self.film.title, words, pictures_of(self.folder))


def recorded(path: Path) -> Recorded:
    """A run by its folder (the film in it, else the bag), a film or a bag.

    Raises:
        FilmError: there is nothing that can be shown; says what was looked for.
    """
    path = path.absolute()
    files = [path / FILM, path / BAG] if path.is_dir() else [path]
    file = next((file for file in files if file.is_file()), None)
    if file is None:
        looked = " and ".join(str(each) for each in files)
        raise FilmError(
            f"nothing to show: there is no {looked}; run_experiment writes a film where it ends by itself, "
            "and a bag with --bag"
        )
    film = film_of_bag(file, PERIOD_S) if file.suffix == ".bag" else Film.read(file)
    film.title = "/".join(file.parent.parts[-2:]) if path.is_dir() else str(path.name)
    return Recorded(film, file.parent)
