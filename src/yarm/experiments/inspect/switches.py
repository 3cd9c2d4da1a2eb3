"""Known faults of the report's program, or what would mend them, each by itself in its round without ROS."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping


@dataclass(frozen=True)
class Switches:
    """What is as in the printed program; by default nothing is.

    Attributes:
        query_from_origin: whether a viewpoint can be reached is asked from (0, 0, 0) instead of the robot.
        empty_map: it is asked on a map that knows no boxes.
        goals_ignored: that a goal failed is not looked at.
        loose_heading: a goal is reached within 17 degrees, so that the headings at a box are one.
        no_neighbours: neighbours and narrow places are not looked at.
        sleeps: the printed program's sleep after each image.
        printed_vote: the printed recognition and vote, on whole images.
        whole_images: the text's recognition and vote, but images are not cropped.
        frames_lost: every third image does not come.
        frames_copied: the images that a standing robot takes are one and the same.
        turns_lost: the turns that localise do not reach the base, as with a publisher made anew for each message.
        home_early: home is where it believes to be before it has turned.
        no_goal_limit: a goal may take for ever.
        doubts_unheard: whatever the localisation holds for the place is driven by, as AMCL says of no place that it
            is not sure of it; ours would stop the robot.
        strangers: every third of the tags is a picture that is in no set; its recognition knows no such thing.
        exact_order: not a fault but the remedy of one: the shortest order instead of the greedy one.
        large_only: the same: outlines count from LARGE_PX2 on instead of 3000 px2.
        inliers_used: the same: an outline counts if LEAST_INLIERS of its matches agree with it.
    """

    query_from_origin: bool = False
    empty_map: bool = False
    goals_ignored: bool = False
    loose_heading: bool = False
    no_neighbours: bool = False
    sleeps: bool = False
    printed_vote: bool = False
    whole_images: bool = False
    frames_lost: bool = False
    frames_copied: bool = False
    turns_lost: bool = False
    home_early: bool = False
    no_goal_limit: bool = False
    doubts_unheard: bool = False
    strangers: bool = False
    exact_order: bool = False
    large_only: bool = False
    inliers_used: bool = False


LOOSE_RAD = 0.3
"""About 17 degrees."""
LARGE_PX2 = 40000.0
"""A little less than the outline of a tag 0.8 m away, seen from 60 degrees: the farthest that the text looks at."""
LEAST_INLIERS = 10
"""Four matches agree with any homography through them."""
STRANGE_EVERY = 3
"""One in so many tags is a stranger's."""
PLAIN = "as the text has it"
FAULTS: Mapping[str, Switches] = {
    PLAIN: Switches(),
    "reachable from (0, 0, 0)": Switches(query_from_origin=True),
    "map without boxes": Switches(empty_map=True),
    "map without boxes, failed goals ignored": Switches(empty_map=True, goals_ignored=True),
    "headings within the tolerance": Switches(loose_heading=True),
    "neighbours not looked at": Switches(no_neighbours=True),
    "sleeps": Switches(sleeps=True),
    "printed recognition": Switches(printed_vote=True),
    "images not cropped": Switches(whole_images=True),
    "every third frame lost": Switches(frames_lost=True),
    "every third frame lost, printed recognition": Switches(frames_lost=True, printed_vote=True),
    "seven frames are one": Switches(frames_copied=True),
    "seven frames are one, headings within the tolerance": Switches(frames_copied=True, loose_heading=True),
    "every third tag a stranger's": Switches(strangers=True),
    "exact order instead of greedy": Switches(exact_order=True),
    "outlines from 40 000 px2 on": Switches(large_only=True),
    "outlines with 10 inliers or more": Switches(inliers_used=True),
    "every third tag a stranger's, both of these": Switches(strangers=True, large_only=True, inliers_used=True),
}
"""Variants of the report's round, by their names in the figure."""
FAULTS_IN_PHYSICS: Mapping[str, Switches] = {
    PLAIN: Switches(),
    "turns lost": Switches(turns_lost=True, doubts_unheard=True),
    "home taken before the turns": Switches(home_early=True),
    "home taken early, turns lost": Switches(home_early=True, turns_lost=True, doubts_unheard=True),
    "goals without a limit": Switches(no_goal_limit=True),
    "map without boxes": Switches(empty_map=True, doubts_unheard=True),
    "map without boxes, goals without a limit": Switches(empty_map=True, no_goal_limit=True, doubts_unheard=True),
}
"""Those that need a real localisation and navigation to cost something: tried in full physics."""
