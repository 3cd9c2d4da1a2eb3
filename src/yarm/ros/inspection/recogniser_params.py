"""Parameters of the node ``tag_recogniser``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, List, Mapping, Tuple

from yarm.inspection.inputs import read_tags
from yarm.params import ParamError, build, param
from yarm.tags.free_look import FreeSettings
from yarm.tags.motifs import GreyImage
from yarm.tags.pictures import PictureError, read_picture, shipped_pictures, twins
from yarm.yaml_fields import SceneError

Tags = Mapping[int, GreyImage]


@dataclass(frozen=True)
class TagRecogniserParams(FreeSettings):
    """What ``config/inspection/tag_recogniser.yaml`` holds."""

    rate: float = param(5.0, "Hz", "pictures that are looked at, at most", low=0.1, high=60.0)
    tags: str = param("", "", "file that names the tags, YAML or templates.xml; empty: the shipped ones")


def pictures_of(path: str) -> Tags:
    """The pictures a file names, by their numbers; the shipped ones without a file.

    Raises:
        SceneError: faults in the file, all listed.
        PictureError: a picture cannot be used, or two are the same.
    """
    if not path:
        return shipped_pictures()
    files = {tag.number: tag.path for tag in read_tags(Path(path).expanduser())}
    pictures = {number: read_picture(file) for number, file in files.items()}
    same = [f"tags {a} and {b} ({files[a].name}, {files[b].name}) show the same picture" for a, b in twins(pictures)]
    if same:
        raise PictureError(f"{path}: {'; '.join(same)}; a box that bears it could be either: leave one out")
    return pictures


def recogniser_params(values: Mapping[str, Any], where: str) -> Tuple[TagRecogniserParams, Tags]:
    """The node's parameters, and the pictures they name.

    Raises:
        ParamError: everything that is wrong, at once.
    """
    faults: List[str] = []
    try:
        params = build(TagRecogniserParams, values, where)
    except ParamError as error:
        faults.append(str(error).replace(f"{where}: ", "", 1))
        params = TagRecogniserParams()
        known = {name: values[name] for name in ("detector", "tags") if isinstance(values.get(name), str)}
        params = build(TagRecogniserParams, known)
    faults += params.faults
    pictures: Tags = {}
    try:
        pictures = pictures_of(params.tags)
    except (SceneError, PictureError) as error:
        faults.append(f"tags = {params.tags!r}: {error}")
    if faults:
        raise ParamError(f"{where}: " + "; ".join(faults))
    return params, pictures
