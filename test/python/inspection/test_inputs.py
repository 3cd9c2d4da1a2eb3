"""Files a round is given: both forms say the same; what is wrong is named with file, key and value."""

from __future__ import annotations

from pathlib import Path

import pytest

from yarm.inspection.inputs import read_boxes, read_tags
from yarm.resources import resource
from yarm.yaml_fields import SceneError

YAML = resource("scenes", "inspection", "practice_boxes.yaml")


def xml_of(path: Path) -> str:
    lines = [
        f"<coordinate{b.number}> {b.pose.x} {b.pose.y} {b.pose.yaw_rad} </coordinate{b.number}>"
        for b in read_boxes(path)
    ]
    return "<?xml version='1.0'?>\n<opencv_storage>" + "\n".join(lines) + "</opencv_storage>"


def written(folder: Path, name: str, text: str) -> Path:
    (folder / name).write_text(text)
    return folder / name


def test_both_forms_say_the_same(tmp_path: Path) -> None:
    assert read_boxes(written(tmp_path, "coords.xml", xml_of(YAML))) == read_boxes(YAML)


@pytest.mark.parametrize("n", [1, 30])
def test_any_number_of_boxes_works(tmp_path: Path, n: int) -> None:
    text = "boxes:\n" + "".join(f"  - {{x: {2.0 * i}, y: 0.0, phi: 0.0}}\n" for i in range(n))
    assert [box.number for box in read_boxes(written(tmp_path, "boxes.yaml", text))] == list(range(1, n + 1))


@pytest.mark.parametrize(
    "text, part",
    [
        ("boxes: []", "0 boxes"),
        ("boxes:\n" + "".join(f"  - {{x: {i}, y: 0.0, phi: 0.0}}\n" for i in range(31)), "at most 30"),
        ("boxes:\n  - {x: 0.0, y: 0.0, phi: 134.0}", "degrees are not meant"),
        ("boxes:\n  - {x: 0.0, y: 0.0, phi: 0.0}\n  - {x: 0.001, y: 0.0, phi: 0.0}", "given twice"),
        ("boxes:\n  - {x: 0.0, y: 0.0, phi: 0.0}\n  - {number: 1, x: 3.0, y: 0.0, phi: 0.0}", "given once"),
        ("boxes:\n  - {x: 0.0, y: 0.0, phi: 0.0}\n  - {x: 0.0, y: 0.1, phi: 1.57}", "overlap by 0.15 m at most"),
        ("boxes:\n  - {x: .nan, y: 0.0, phi: 0.0}", "boxes[0].x"),
        ("boxes:\n  - {x: 1.0, y: 0.0, phi: 0.0, colour: red}", "colour"),
    ],
)
def test_wrong_boxes_are_named(tmp_path: Path, text: str, part: str) -> None:
    with pytest.raises(SceneError) as caught:
        read_boxes(written(tmp_path, "boxes.yaml", text))
    assert part in str(caught.value) and "boxes.yaml" in str(caught.value)


@pytest.mark.parametrize(
    "text, part",
    [
        ("<opencv_storage><coordinate1> 1 2 </coordinate1></opencv_storage>", "three finite numbers"),
        ("<opencv_storage><coordinate1> 1 2 inf </coordinate1></opencv_storage>", "three finite numbers"),
        ("<opencv_storage><coordinate1> 1 2 90 </coordinate1></opencv_storage>", "degrees are not meant"),
        ("<opencv_storage><box1> 1 2 0 </box1></opencv_storage>", "box1"),
        ("<storage></storage>", "<storage>"),
        ("<opencv_storage>", "an <opencv_storage> file"),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><opencv_storage></opencv_storage>", "without entities"),
    ],
)
def test_wrong_storage_files_are_named(tmp_path: Path, text: str, part: str) -> None:
    with pytest.raises(SceneError) as caught:
        read_boxes(written(tmp_path, "coords.xml", text))
    assert part in str(caught.value) and "coords.xml" in str(caught.value)


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="a file that is there"):
        read_boxes(tmp_path / "coords.xml")


def test_tags_of_both_forms(tmp_path: Path) -> None:
    for i in (1, 2):
        written(tmp_path, f"tag {i}.png", "")
    xml = written(
        tmp_path, "t.xml", '<opencv_storage><templates> "tag 1.png" "tag 2.png" </templates></opencv_storage>'
    )
    plain = written(tmp_path, "t.yaml", "tags:\n  - {number: 1, file: tag 1.png}\n  - {number: 2, file: tag 2.png}\n")
    assert read_tags(xml) == read_tags(plain) and [tag.number for tag in read_tags(xml)] == [1, 2]


@pytest.mark.parametrize(
    "name, text, part",
    [
        ("t.yaml", "tags:\n  - {number: 1, file: gone.png}", "gone.png"),
        ("t.yaml", "tags: []", "0 tags"),
        ("t.yaml", "tags:\n  - {number: 1, file: t.yaml}\n  - {number: 1, file: t.yaml}", "given once"),
        ("t.xml", '<opencv_storage><templates> "open </templates></opencv_storage>', "in quotes"),
        ("t.xml", "<opencv_storage></opencv_storage>", "one <templates>"),
    ],
)
def test_wrong_tag_lists_are_named(tmp_path: Path, name: str, text: str, part: str) -> None:
    with pytest.raises(SceneError) as caught:
        read_tags(written(tmp_path, name, text))
    assert part in str(caught.value)
