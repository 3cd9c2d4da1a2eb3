"""Parameters of the node ``inspector``."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Dict, List, Mapping, Sequence, Tuple

from yarm.inspection.boxes import Box
from yarm.inspection.inputs import read_boxes
from yarm.inspection.model import CONTROLLERS, OURS
from yarm.inspection.report_round import ReportRoundParams
from yarm.inspection.round import RoundParams
from yarm.inspection.session import SessionParams
from yarm.params import ParamError, build_noting, param
from yarm.ros.inspection.recogniser_params import Tags, pictures_of
from yarm.tags.features import DETECTOR, detector_fault
from yarm.tags.pictures import PictureError
from yarm.yaml_fields import SceneError

REPORT = "report"
"""Namespace of the numbers of the report's round, and the controller that takes them."""


@dataclass(frozen=True)
class InspectorParams(RoundParams):
    """What ``config/inspection/inspector.yaml`` holds: our round's numbers, and what the node needs."""

    controller: str = param("yarm", "", "whose round is driven", choices=CONTROLLERS)
    boxes: str = param("", "", "file of the boxes, YAML or coords.xml; empty: the practice world's")
    tags: str = param("", "", "file that names the tags, YAML or templates.xml; empty: the shipped ones")
    result: str = param("inspection_result.txt", "", "the result is written here, line by line; its folder is made")
    autostart: bool = param(True, "", "begin as soon as everything is there; false: wait for ~start")
    base_frame: str = param("base_footprint", "", "the robot's frame")
    odom_frame: str = param("odom", "", "odometry's frame")
    map_frame: str = param("map", "", "the map's frame")
    visualize: bool = param(True, "", "publish boxes, viewpoints and time left for RViz")
    sync: bool = param(False, "", "lock-step: take in all of a pass before it is decided, and acknowledge it")
    waits_for: Tuple[str, ...] = param((), "", "lock-step: nodes that must have answered before the first pass")
    sync_wait: float = param(2.0, "s", "lock-step: wall time a pass waits for what was measured at it", 0.01, 60.0)

    @property
    def round(self) -> RoundParams:
        """Our round's own."""
        return RoundParams(**{f.name: getattr(self, f.name) for f in fields(RoundParams)})

    @property
    def session(self) -> SessionParams:
        """The session's."""
        return SessionParams(self.time_limit_s, self.turn_rate, self.autostart)

    @property
    def result_path(self) -> Path:
        """Where the result goes, absolute."""
        return Path(self.result).expanduser().absolute()


@dataclass(frozen=True)
class InspectorReportParams(ReportRoundParams):
    """What ``config/inspection/inspector_report.yaml`` holds: the numbers of the report's round, and how it reads."""

    detector: str = param(DETECTOR, "", "whose features it matches: sift, orb, akaze; surf where the build has it")


@dataclass(frozen=True, eq=False)
class Inspected:
    """What a round is given, read and checked.

    Attributes:
        params: of the node.
        report: of the report's round and how it reads.
        boxes: in the order of their numbers.
        tags: pictures by number.
    """

    params: InspectorParams
    report: InspectorReportParams
    boxes: Tuple[Box, ...]
    tags: Tags

    @property
    def detector(self) -> str:
        """Whose features the round's recognition matches."""
        return DETECTOR if self.params.controller == OURS else self.report.detector


def inspector_params(values: Mapping[str, Any], practice_boxes: Path, where: str) -> Inspected:
    """The node's parameters, and what the files hold that they name.

    Args:
        values: as the parameter server has them; those of the report's round are under ``report``.
        practice_boxes: file that is read when no other is named.
        where: name of the node, for messages.

    Raises:
        ParamError: everything that is wrong, at once: unknown names, values out of range, faults in the files.
    """
    faults: List[str] = []
    plain = {name: value for name, value in values.items() if name != REPORT}
    params = build_noting(InspectorParams, plain, "", faults)
    report = build_noting(InspectorReportParams, values.get(REPORT, {}), f"{REPORT}.", faults)
    missing = "" if report is None else detector_fault(report.detector)
    if report is not None and missing:
        faults.append(f"{REPORT}.detector = {report.detector!r}: {missing}")
    files: Dict[str, str] = {name: plain[name] for name in ("boxes", "tags") if isinstance(plain.get(name), str)}
    boxes: Sequence[Box] = ()
    tags: Tags = {}
    try:
        named = files.get("boxes", "")
        boxes = read_boxes(Path(named).expanduser() if named else practice_boxes)
    except SceneError as error:
        faults.append(f"boxes = {files.get('boxes', '')!r}: {error}")
    try:
        tags = pictures_of(files.get("tags", ""))
    except (SceneError, PictureError) as error:
        faults.append(f"tags = {files.get('tags', '')!r}: {error}")
    if params is not None:
        faults += _folder_fault(params)
    if faults or params is None or report is None:
        raise ParamError(f"{where}: " + "; ".join(faults))
    return Inspected(params, report, tuple(boxes), tags)


def _folder_fault(params: InspectorParams) -> List[str]:
    folder = params.result_path.parent
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        return [f"result = {params.result!r}: {folder} cannot be made: {error.strerror}"]
    return []
