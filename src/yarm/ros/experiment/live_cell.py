"""The live cell as ``rosrun yarm what_if`` forks it: its newest map, its Commander's parameters, its raster."""

from __future__ import annotations

import rospy

from yarm.commander.params import CommanderParams
from yarm.experiments.what_if.cell import Cell, NoCellError
from yarm.experiments.what_if.live import arms_of, cell_of_map
from yarm.geometry.kinds import ObjectKind
from yarm.params import build, infos
from yarm.ros.commander.what_if import live_settings, share_done
from yarm.ros.common import names
from yarm.ros.common.conversions import parse_map_metadata
from yarm.ros.common.start import init_command
from yarm.ros.common.stations import load_station

MAP_LIMIT_S = 10.0


def live_cell() -> Cell:
    """The cell as its newest map shows it now.

    Raises:
        NoCellError: there is no map.
    """
    init_command("what_if")
    try:
        message = rospy.wait_for_message(names.PLANNING_METADATA, rospy.AnyMsg, timeout=MAP_LIMIT_S)
        cell_map = parse_map_metadata(message._buff)
    except (rospy.ROSException, ValueError) as error:
        text = f"{names.PLANNING_METADATA}: {error}; is a cell running? Else say --case or --run"
        raise NoCellError(text) from error
    arms = sorted(name for name, found in cell_map.objects.items() if found.kind == ObjectKind.MANIPULATOR)
    given, known = rospy.get_param(names.COMMANDER_NODE, {}), {name for name, _, _ in infos(CommanderParams)}
    params = build(CommanderParams, {name: value for name, value in given.items() if name in known})
    stations = {arm: load_station(arm) for arm in arms_of(cell_map)}
    return cell_of_map(cell_map, stations, live_settings(params), share_done(arms))
