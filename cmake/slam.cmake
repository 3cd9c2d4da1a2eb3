# The ROS-free map maker and localisation (Eigen only), their nodes behind gmapping's and AMCL's names, tests and benchmarks.
find_package(Threads REQUIRED)

# Shared, because Python loads it (yarm.navigation.slam_native).
add_library(yarm_slam SHARED
  src/slam/c_api.cpp
  src/slam/coarse_search.cpp
  src/slam/distance_field.cpp
  src/slam/field_fit.cpp
  src/slam/keyframes.cpp
  src/slam/localiser.cpp
  src/slam/localiser_params.cpp
  src/slam/map_drawer.cpp
  src/slam/mapper.cpp
  src/slam/match.cpp
  src/slam/params.cpp
  src/slam/place_search.cpp
  src/slam/pose_graph.cpp
  src/slam/scan_points.cpp
  src/slam/worker.cpp
)
target_include_directories(yarm_slam PUBLIC ${CMAKE_CURRENT_SOURCE_DIR}/include)
#catkin_lint: ignore_once external_interface_path
target_include_directories(yarm_slam SYSTEM PUBLIC ${EIGEN3_INCLUDE_DIRS})
target_link_libraries(yarm_slam PUBLIC Threads::Threads)
# No fused multiply-add: the same input gives the same map wherever it is built.
target_compile_options(yarm_slam PRIVATE -O3 -Wall -Wextra -Wpedantic -ffp-contract=off -fno-math-errno)
install(TARGETS yarm_slam
  ARCHIVE DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
  LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
)

# The nodes, behind gmapping's and AMCL's names. They compile the executor and the reports themselves: linked with the perception nodes' library they
# would load PCL and FCL, which they have no use for.
add_library(yarm_slam_ros
  src/ros/amcl.cpp
  src/ros/executor.cpp
  src/ros/map_messages.cpp
  src/ros/pulse.cpp
  src/ros/report.cpp
  src/ros/scan_reader.cpp
  src/ros/slam_gmapping.cpp
  src/ros/tf_listener.cpp
)
target_include_directories(yarm_slam_ros PUBLIC ${CMAKE_CURRENT_SOURCE_DIR}/include)
#catkin_lint: ignore_once external_interface_path
target_include_directories(yarm_slam_ros SYSTEM PUBLIC ${catkin_INCLUDE_DIRS})
target_compile_options(yarm_slam_ros PRIVATE -Wall -Wextra -Wpedantic)
target_link_libraries(yarm_slam_ros PUBLIC yarm_slam ${catkin_LIBRARIES})
target_link_options(yarm_slam_ros PRIVATE -Wl,--as-needed)
foreach(node amcl slam_gmapping)
  add_executable(yarm_${node} src/ros/${node}_node.cpp src/ros/loopback.cpp)
  set_target_properties(yarm_${node} PROPERTIES OUTPUT_NAME ${node})
endforeach()
add_executable(yarm_slam_params src/ros/slam_params.cpp)
set_target_properties(yarm_slam_params PROPERTIES OUTPUT_NAME slam_params)
foreach(target yarm_amcl yarm_slam_gmapping yarm_slam_params)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic)
  target_link_libraries(${target} PRIVATE yarm_slam_ros)
  target_link_options(${target} PRIVATE -Wl,--as-needed)
endforeach()
install(TARGETS yarm_slam_ros
  ARCHIVE DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
  LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
)
install(TARGETS yarm_amcl yarm_slam_gmapping yarm_slam_params RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})

# A seeded world with its truth; for tests and the benchmark.
add_library(yarm_slam_world STATIC EXCLUDE_FROM_ALL test/support/slam_score.cpp test/support/slam_world.cpp)
target_include_directories(yarm_slam_world PUBLIC test/support)
target_compile_options(yarm_slam_world PRIVATE -O3 -Wall -Wextra -Wpedantic)
target_link_libraries(yarm_slam_world PUBLIC yarm_slam)

# On demand: bench/slam.py and bench/localisation.py build and run them.
foreach(bench slam localisation)
  #catkin_lint: ignore uninstalled_target
  add_executable(${bench}_bench EXCLUDE_FROM_ALL bench/${bench}.cpp)
  target_compile_options(${bench}_bench PRIVATE -O3 -Wall -Wextra -Wpedantic)
  target_link_libraries(${bench}_bench PRIVATE yarm_slam_world)
endforeach()

# The peer in bench/localisation.py, where MRPT is installed; nothing else needs it.
find_package(mrpt-slam QUIET)
if(mrpt-slam_FOUND)
  #catkin_lint: ignore uninstalled_target
  add_executable(localisation_mrpt_bench EXCLUDE_FROM_ALL bench/localisation_mrpt.cpp)
  target_compile_options(localisation_mrpt_bench PRIVATE -O3 -Wall -Wextra -Wpedantic)
  target_link_libraries(localisation_mrpt_bench PRIVATE yarm_slam_world mrpt::slam)
endif()

if(CATKIN_ENABLE_TESTING)
  # Tours for tests in Python (test/support/slam_log.py).
  #catkin_lint: ignore uninstalled_target
  add_executable(slam_world_log EXCLUDE_FROM_ALL test/support/slam_world_log.cpp)
  target_compile_options(slam_world_log PRIVATE -Wall -Wextra -Wpedantic)
  target_link_libraries(slam_world_log PRIVATE yarm_slam_world)
  add_dependencies(tests slam_world_log)

  foreach(test slam_match_test slam_graph_test slam_map_test slam_mapper_test slam_field_test slam_localiser_test)
    catkin_add_gtest(${test} test/cpp/slam/${test}.cpp)
    target_compile_options(${test} PRIVATE -Wall -Wextra -Wpedantic)
    target_link_libraries(${test} yarm_slam_world gtest_main)
  endforeach()

  # Compiled from the sources that touch what comes from outside, all of them under the sanitizers.
  get_target_property(yarm_slam_sources yarm_slam SOURCES)
  catkin_add_gtest(scan_map_fuzz_test
    test/cpp/ros/scan_map_fuzz_test.cpp
    src/ros/executor.cpp
    src/ros/map_messages.cpp
    src/ros/pulse.cpp
    src/ros/scan_reader.cpp
    src/ros/tf_listener.cpp
    ${yarm_slam_sources}
  )
  yarm_sanitize(scan_map_fuzz_test ${yarm_address_sanitizers})
  target_link_libraries(scan_map_fuzz_test Threads::Threads)
endif()
