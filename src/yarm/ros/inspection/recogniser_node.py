"""Node ``tag_recogniser``: which tags a camera shows, without a map, a robot or a round.

It looks at pictures only while somebody listens to what it finds; whether the camera can be used it always tells.
"""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Callable, Optional, Tuple

import cv2
import numpy as np
import rospy
from sensor_msgs.msg import Image
from std_msgs.msg import Float32MultiArray

from yarm.inspection.model import Stage
from yarm.msg import InspectionStatus, TagVerdict
from yarm.params import ParamError
from yarm.ros.common import names
from yarm.ros.common.clock import ClockWatch
from yarm.ros.common.start import init_node
from yarm.ros.inspection.health import HealthReport
from yarm.ros.inspection.images import take_picture
from yarm.ros.inspection.recogniser_params import TagRecogniserParams, Tags, pictures_of, recogniser_params
from yarm.ros.inspection.verdicts import free_verdict
from yarm.srv import (
    AddTag,
    AddTagRequest,
    AddTagResponse,
    LoadTags,
    LoadTagsRequest,
    LoadTagsResponse,
    RemoveTag,
    RemoveTagRequest,
    RemoveTagResponse,
)
from yarm.tags.features import DetectorError
from yarm.tags.free_look import FreeLook, FreeRecogniser, qt_homography
from yarm.tags.motifs import GreyImage
from yarm.tags.picture_watch import PictureWatch
from yarm.tags.pictures import PictureError, read_picture
from yarm.tags.report import ImageError
from yarm.yaml_fields import SceneError

REPORT_S = 1.0
IMAGE_BYTES = 2**22
OUTLINE, OTHER_OUTLINE = (60, 220, 60), (0, 170, 255)
"""Blue, green, red of the first tag's outline and of the others'."""
Refused = (ValueError, SceneError, PictureError, ImageError)


class TagRecogniserNode:
    """Ties a camera to the recognition. Every callback takes the lock."""

    def __init__(self, params: TagRecogniserParams, tags: Tags) -> None:
        """Listen and advertise.

        Raises:
            DetectorError: the installed OpenCV does not have this detector.
            ValueError: a tag that can never be found.
        """
        self._params = params
        self._lock = threading.Lock()
        self._recogniser = _recogniser(params, tags)
        self._watch = PictureWatch()
        self._due_s = 0.0
        self._last: Optional[FreeLook] = None
        self._box = 0
        self._verdict = rospy.Publisher("~verdict", TagVerdict, queue_size=10)
        self._objects = rospy.Publisher(names.OBJECTS, Float32MultiArray, queue_size=10)
        self._image = rospy.Publisher("~image", Image, queue_size=2)
        self._health = HealthReport()
        self._services = [
            rospy.Service("~add_tag", AddTag, self._on_add),
            rospy.Service("~remove_tag", RemoveTag, self._on_remove),
            rospy.Service("~load_tags", LoadTags, self._on_load),
        ]
        self._clock = ClockWatch()
        self._clock.on_reset(self._on_clock_reset)
        self._subscriber = rospy.Subscriber(
            names.RGB_IMAGE, Image, self._on_image, queue_size=1, buff_size=2 * IMAGE_BYTES, tcp_nodelay=True
        )
        self._status = rospy.Subscriber(names.inspector("status"), InspectionStatus, self._on_status, queue_size=1)
        self._timer = rospy.Timer(rospy.Duration(REPORT_S), self._report, reset=True)

    def _on_image(self, message: Image) -> None:
        now_s = rospy.get_time()
        grey, fault = take_picture(message)
        with self._lock:
            if fault:
                self._watch.refuse(fault, now_s)
            else:
                fault = self._watch.take(message.header.stamp.to_sec(), grey, now_s)
            wanted = any(p.get_num_connections() for p in (self._verdict, self._objects, self._image))
            if not wanted or now_s < self._due_s:
                return
            self._due_s = now_s + 1.0 / self._params.rate
            look = FreeLook(reason=fault) if fault else self._look(grey)
            self._last, box = look, self._box
        self._tell(message, grey, look, box)

    def _look(self, grey: GreyImage) -> FreeLook:
        try:
            return self._recogniser.look(grey)
        except ImageError as error:
            return FreeLook(reason=str(error))

    def _on_status(self, message: InspectionStatus) -> None:
        """A round, if there is one, knows which box the camera is pointed at."""
        with self._lock:
            self._box = message.box if message.stage == Stage.LOOK else 0

    def _tell(self, message: Image, grey: GreyImage, look: FreeLook, box: int) -> None:
        verdict = free_verdict(look)
        verdict.header, verdict.box = message.header, box
        self._verdict.publish(verdict)
        objects = Float32MultiArray()
        for sight in look.sights:
            objects.data += [float(sight.tag), *map(float, sight.size), *qt_homography(sight.homography)]
        self._objects.publish(objects)
        if self._image.get_num_connections() and grey.size:
            drawn = picture_message(outlined(grey, look))
            drawn.header = message.header
            self._image.publish(drawn)

    def _report(self, _: object) -> None:
        with self._lock:
            fault = self._watch.fault(rospy.get_time())
            tags = len(self._recogniser.tags)
        complaints = [f"{rospy.resolve_name(names.RGB_IMAGE)}: {fault}"] if fault else []
        complaints += [] if tags else ["no tags are loaded; use ~load_tags or ~add_tag"]
        self._health.send(complaints, f"{tags} tags, detector {self._params.detector}")

    def _on_clock_reset(self) -> None:
        with self._lock:
            self._watch, self._due_s, self._box = PictureWatch(), 0.0, 0

    def _on_add(self, request: AddTagRequest) -> AddTagResponse:
        def add() -> str:
            if request.path:
                picture = read_picture(Path(request.path).expanduser())
            else:
                picture, fault = take_picture(request.image)
                if fault:
                    raise ValueError(f"image: {fault}")
            with self._lock:
                self._recogniser.add(request.number, picture)
                return f"tag {request.number} is looked for; {len(self._recogniser.tags)} tags"

        return AddTagResponse(*_answer(add))

    def _on_remove(self, request: RemoveTagRequest) -> RemoveTagResponse:
        def remove() -> str:
            with self._lock:
                if not self._recogniser.remove(request.number):
                    raise ValueError(f"tag {request.number} is not known; known: {list(self._recogniser.tags)}")
                return f"{len(self._recogniser.tags)} tags are left"

        return RemoveTagResponse(*_answer(remove))

    def _on_load(self, request: LoadTagsRequest) -> LoadTagsResponse:
        def load() -> str:
            made = _recogniser(self._params, pictures_of(request.path))
            with self._lock:
                self._recogniser = made
            return f"{len(made.tags)} tags are looked for"

        return LoadTagsResponse(*_answer(load))


def _recogniser(params: TagRecogniserParams, tags: Tags) -> FreeRecogniser:
    made = FreeRecogniser(params)
    for number, picture in tags.items():
        made.add(number, picture)
    return made


def _answer(work: Callable[[], str]) -> Tuple[bool, str]:
    """Success and message of a service that may be refused."""
    try:
        return True, work()
    except Refused as error:
        return False, str(error)


def outlined(grey: GreyImage, look: FreeLook) -> GreyImage:
    """(h, w, 3) blue, green, red: the picture with the outline and number of every tag."""
    drawn: GreyImage = cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR)
    for i, sight in enumerate(look.sights):
        colour = OTHER_OUTLINE if i else OUTLINE
        corners = np.round(np.clip(sight.corners, -4000, 4000)).astype(np.int32)
        cv2.polylines(drawn, [corners], True, colour, 2, cv2.LINE_AA)
        at = (int(corners[:, 0].min()), max(14, int(corners[:, 1].min()) - 6))
        cv2.putText(drawn, str(sight.tag), at, cv2.FONT_HERSHEY_SIMPLEX, 0.7, colour, 2, cv2.LINE_AA)
    return drawn


def picture_message(picture: GreyImage) -> Image:
    """An (h, w) grey or (h, w, 3) blue, green, red picture as a message."""
    height, width = picture.shape[:2]
    channels = 1 if picture.ndim == 2 else picture.shape[2]
    encoding = "mono8" if channels == 1 else "bgr8"
    return Image(height=height, width=width, encoding=encoding, step=channels * width, data=picture.tobytes())


def main() -> int:
    """Run the node until it is shut down; 1 when its parameters are refused."""
    init_node("tag_recogniser")
    try:
        made = TagRecogniserNode(*recogniser_params(rospy.get_param("~", {}), rospy.get_name()))
    except (ParamError, DetectorError, ValueError) as error:
        rospy.logfatal("%s", error)
        return 1
    rospy.spin()
    del made
    return 0
