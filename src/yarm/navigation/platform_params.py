"""A configuration of the platform's own move_base, by its names: what of it is used here, and what has no effect.

The platform keeps the costmaps' and planners' numbers in namespaces of theirs (``global_costmap/robot_radius``,
``DWAPlannerROS/max_vel_x``). Its files are taken as they are; a name that move_base, costmap_2d, navfn, global_planner,
dwa_local_planner, base_local_planner and the recovery behaviours of ROS Noetic do not know is refused. Pure.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Callable, Dict, FrozenSet, Iterator, List, Mapping, Optional, Tuple

from yarm.navigation.move_base_params import CLEAR, TURN

NamesIn = Callable[[Mapping[str, Any]], FrozenSet[str]]
PLUGINS, SOURCES, RECOVERIES = "plugins", "observation_sources", "recovery_behaviors"
LOCAL_PLANNER, PLATFORMS_PLANNER = "base_local_planner", "DWAPlannerROS"
UNUSED = "the platform's own costmaps, planners and recovery"
"""What the other names are for."""
RECOVERY_OF: Dict[str, str] = {
    "clear_costmap_recovery/ClearCostmapRecovery": CLEAR,
    "move_slow_and_clear/MoveSlowAndClear": CLEAR,
    "rotate_recovery/RotateRecovery": TURN,
}
"""Of each recovery behaviour of the platform, ours."""
COSTMAP_USED: Dict[str, Tuple[str, ...]] = {
    "robot_radius": ("robot_radius",),
    "inflation_radius": ("inflation_layer/inflation_radius", "inflation_radius"),
    "cost_scaling_factor": ("inflation_layer/cost_scaling_factor", "cost_scaling_factor"),
    "obstacle_range": ("obstacle_layer/obstacle_range", "obstacle_range"),
    "raytrace_range": ("obstacle_layer/raytrace_range", "raytrace_range"),
}
"""Where ``global_costmap`` holds what a parameter of ours means; the first that is there counts."""
PLANNER_USED: Dict[str, Tuple[str, ...]] = {
    "max_vel_x": ("max_vel_x",),
    "max_vel_theta": ("max_vel_theta", "max_rot_vel"),
    "xy_goal_tolerance": ("xy_goal_tolerance",),
    "yaw_goal_tolerance": ("yaw_goal_tolerance",),
}
"""The same of the local planner that ``base_local_planner`` names, else of the platform's."""


def _none(_: Mapping[str, Any]) -> FrozenSet[str]:
    return frozenset()


@dataclass(frozen=True)
class Space:
    """A namespace: parameters, namespaces in it, and ``inner``, which parameters of it call as they like: ``named``."""

    names: FrozenSet[str]
    spaces: Mapping[str, Space] = field(default_factory=dict)
    named: NamesIn = _none
    inner: Optional[Space] = None

    def inside(self, values: Mapping[str, Any]) -> Dict[str, Space]:
        """Every namespace that these values may hold."""
        free = {} if self.inner is None else dict.fromkeys(self.named(values), self.inner)
        return {**free, **self.spaces}


def _words(text: str) -> FrozenSet[str]:
    return frozenset(text.split())


def _listed(parameter: str) -> NamesIn:
    """Names in a list of plugins, each a mapping with name and type."""

    def names(values: Mapping[str, Any]) -> FrozenSet[str]:
        entries = values.get(parameter)
        plugins = entries if isinstance(entries, (list, tuple)) else ()
        return frozenset(str(plugin["name"]) for plugin in plugins if isinstance(plugin, Mapping) and "name" in plugin)

    return names


def _sources(values: Mapping[str, Any]) -> FrozenSet[str]:
    return _words(str(values.get(SOURCES, "")))


SOURCE = Space(
    _words(
        "clearing data_type expected_update_rate inf_is_valid marking max_obstacle_height min_obstacle_height "
        "observation_persistence obstacle_range raytrace_range sensor_frame topic"
    )
)
LAYER = Space(
    _words(
        "combination_method cost_scaling_factor enabled first_map_only footprint_clearing_enabled inflate_unknown "
        "inflation_radius lethal_cost_threshold map_topic mark_threshold max_obstacle_height min_obstacle_height "
        "observation_sources obstacle_range origin_z publish_voxel_map raytrace_range restore_defaults "
        "subscribe_to_updates track_unknown_space trinary_costmap unknown_cost_value unknown_threshold use_maximum "
        "z_resolution z_voxels"
    ),
    named=_sources,
    inner=SOURCE,
)
COSTMAP = Space(
    LAYER.names
    | _words(
        "always_send_full_costmap circumscribed_radius footprint footprint_padding footprint_topic global_frame height "
        "inscribed_radius map_type origin_x origin_y plugins publish_frequency resolution robot_base_frame "
        "robot_radius rolling_window static_map transform_tolerance update_frequency width"
    ),
    dict.fromkeys(("footprint_layer", "inflation_layer", "obstacle_layer", "static_layer", "voxel_layer"), LAYER),
    lambda values: _sources(values) | _listed(PLUGINS)(values),
    Space(LAYER.names | SOURCE.names, named=_sources, inner=SOURCE),
)
NAVFN = Space(
    _words(
        "allow_unknown costmap_publish_frequency default_tolerance planner_costmap_publish_frequency planner_window_x "
        "planner_window_y visualize_potential"
    )
)
GLOBAL_PLANNER = Space(
    NAVFN.names
    | _words(
        "cost_factor lethal_cost neutral_cost old_navfn_behavior orientation_mode orientation_window_size outline_map "
        "publish_potential publish_scale restore_defaults use_dijkstra use_grid_path use_quadratic"
    )
)
LIMITS = _words(
    "acc_lim_th acc_lim_theta acc_lim_trans acc_lim_x acc_lim_y acc_limit_trans angular_sim_granularity "
    "controller_frequency forward_point_distance global_frame_id goal_distance_bias holonomic_robot "
    "latch_xy_goal_tolerance max_rot_vel max_scaling_factor max_trans_vel max_vel_theta max_vel_trans max_vel_x "
    "max_vel_y meter_scoring min_rot_vel min_trans_vel min_vel_theta min_vel_trans min_vel_x min_vel_y occdist_scale "
    "oscillation_reset_angle oscillation_reset_dist path_distance_bias prune_plan publish_cost_grid "
    "publish_cost_grid_pc publish_traj_pc restore_defaults rot_stopped_vel scaling_speed sim_granularity sim_period "
    "sim_time stop_time_buffer theta_stopped_vel trans_stopped_vel vth_samples vtheta_samples vx_samples vy_samples "
    "xy_goal_tolerance yaw_goal_tolerance"
)
DWA = Space(LIMITS | _words("cheat_factor penalize_negative_x twirling_scale use_dwa"))
TRAJECTORY = Space(
    LIMITS
    | _words(
        "backup_vel dwa escape_reset_dist escape_reset_theta escape_vel gdist_scale heading_lookahead heading_scoring "
        "heading_scoring_timestep max_rotational_vel min_in_place_rotational_vel min_in_place_vel_theta pdist_scale "
        "simple_attractor world_model y_vels"
    )
)
RECOVERY = Space(
    _words(
        "acc_lim_th affected_maps clearing_distance force_updating frequency invert_area_to_clear layer_names "
        "limited_distance limited_rot_speed limited_trans_speed max_rot_param_name max_rotational_vel "
        "max_trans_param_name min_in_place_rotational_vel planner_namespace reset_distance sim_granularity "
        "yaw_goal_tolerance"
    )
)
PLATFORM = Space(
    _words(
        "base_global_planner base_local_planner clearing_radius conservative_reset_dist make_plan_add_unreachable_goal "
        "make_plan_clear_costmap max_planning_retries planner_retry_frequency restore_defaults shutdown_costmaps"
    ),
    {
        "global_costmap": COSTMAP,
        "local_costmap": COSTMAP,
        "NavfnROS": NAVFN,
        "GlobalPlanner": GLOBAL_PLANNER,
        "DWAPlannerROS": DWA,
        "TrajectoryPlannerROS": TRAJECTORY,
        **dict.fromkeys(("conservative_reset", "aggressive_reset", "rotate_recovery"), RECOVERY),
    },
    _listed(RECOVERIES),
    RECOVERY,
)
"""Of move_base itself, beside the names that ours has too."""


@dataclass(frozen=True)
class Taken:
    """A configuration in our names.

    Attributes:
        values: by our names, and whatever is nobody's.
        sources: of each of ours that has come from a name of the platform's, that name.
        unused: names of the platform's that are set and have no effect, sorted.
        faults: unknown names in the platform's namespaces, and values that can be none.
    """

    values: Dict[str, Any]
    sources: Dict[str, str]
    unused: Tuple[str, ...]
    faults: Tuple[str, ...]


def take_platform(values: Mapping[str, Any]) -> Taken:
    """A configuration, as the parameter server has it, in our names.

    What the platform's names say counts before the same thing under our name: whoever loads its file means it.
    """
    faults: List[str] = []
    spaces = PLATFORM.inside(values)
    theirs = {name: value for name, value in values.items() if name in PLATFORM.names or name in spaces}
    ours = {name: value for name, value in values.items() if name not in theirs}
    found = dict(_leaves(theirs, PLATFORM.names, spaces, "", faults))
    planner = str(values.get(LOCAL_PLANNER, PLATFORMS_PLANNER)).rpartition("/")[2]
    sources: Dict[str, str] = {}
    for name, places in used_names(planner).items():
        for place in places:
            if place in found:
                ours[name], sources[name] = found[place], place
                break
    if _listed(RECOVERIES)(values):
        ours[RECOVERIES] = _recoveries(values[RECOVERIES], faults)
    used = set(sources.values())
    if any(source.startswith(f"{planner}/") for source in used):
        used.add(LOCAL_PLANNER)
    return Taken(ours, sources, tuple(sorted(set(found) - used)), tuple(faults))


def used_names(planner: str = PLATFORMS_PLANNER) -> Dict[str, Tuple[str, ...]]:
    """Of each parameter of ours, the platform's names that mean it; ``planner`` is the local planner's namespace."""
    of_costmap = {name: tuple(f"global_costmap/{p}" for p in places) for name, places in COSTMAP_USED.items()}
    return {**of_costmap, **{name: tuple(f"{planner}/{p}" for p in places) for name, places in PLANNER_USED.items()}}


def documented() -> List[Tuple[str, str]]:
    """Names of the platform's and what they mean here: those that are used one by one, all others by namespace."""
    rows = [(place, f"taken as {name}") for name, places in used_names().items() for place in places]
    rows += [(f"{RECOVERIES}: type {theirs}", f"taken as {ours}") for theirs, ours in RECOVERY_OF.items()]
    rows.append((LOCAL_PLANNER, f"whose namespace the speeds and tolerances are taken from; else {PLATFORMS_PLANNER}"))
    others = [", ".join(sorted(PLATFORM.names - {LOCAL_PLANNER}))]
    others += [f"{path}: {', '.join(sorted(space.names))}" for path, space in _spaces(PLATFORM, "")]
    return rows + [(names, f"{UNUSED}; without effect here but for the names above") for names in others]


def _spaces(space: Space, path: str) -> Iterator[Tuple[str, Space]]:
    """Every kind of namespace below one, with all its names; <any> is one that a parameter names."""
    alike: Dict[int, List[str]] = {}
    kinds = {id(inner): inner for inner in (*space.spaces.values(), space.inner) if inner is not None}
    for name, inner in (*space.spaces.items(), ("<any>", space.inner)):
        if inner is not None:
            alike.setdefault(id(inner), []).append(name)
    for kind, called in alike.items():
        whole = f"{path}{called[0] if len(called) == 1 else '{' + ', '.join(called) + '}'}"
        yield whole, kinds[kind]
        yield from _spaces(kinds[kind], f"{whole}/")


def _leaves(
    values: Mapping[str, Any],
    names: FrozenSet[str],
    spaces: Mapping[str, Space],
    path: str,
    faults: List[str],
) -> Iterator[Tuple[str, Any]]:
    """Whole name and value of each parameter that is known; what is not known becomes a fault."""
    for name, value in values.items():
        whole, is_space = path + name, isinstance(value, Mapping)
        if is_space and name in spaces:
            space = spaces[name]
            yield from _leaves(value, space.names, space.inside(value), f"{whole}/", faults)
        elif not is_space and name in names:
            yield whole, value
        elif name in names or name in spaces:
            faults.append(f"{whole}: must be {'a namespace' if name in spaces else 'one value, not a namespace'}")
        else:
            faults.append(f"{whole}: unknown parameter; known: {', '.join(sorted({*names, *spaces}))}")


def _recoveries(behaviors: Any, faults: List[str]) -> List[str]:
    """Ours for the platform's list of plugins."""
    ours = []
    for behavior in behaviors:
        kind = behavior.get("type") if isinstance(behavior, Mapping) else behavior
        if kind in RECOVERY_OF:
            ours.append(RECOVERY_OF[kind])
        else:
            faults.append(f"{RECOVERIES}: type {kind!r} must be one of {', '.join(RECOVERY_OF)}")
    return ours
