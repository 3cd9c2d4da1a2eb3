# The perception nodes: nodelets, and the same classes as standalone nodes.
if(NOT TARGET yarm_perception)
  return()
endif()
add_library(yarm_nodelets SHARED
  src/ros/cloud_reader.cpp
  src/ros/cluster_assoc.cpp
  src/ros/conversions.cpp
  src/ros/cell_markers.cpp
  src/ros/database.cpp
  src/ros/prediction.cpp
  src/ros/executor.cpp
  src/ros/in_process.cpp
  src/ros/merge_clouds.cpp
  src/ros/nodelets.cpp
  src/ros/pulse.cpp
  src/ros/report.cpp
  src/ros/tf_listener.cpp
  src/ros/tf_source.cpp
  src/ros/tracks.cpp
  src/ros/visibility.cpp
)
target_include_directories(yarm_nodelets PUBLIC ${CMAKE_CURRENT_SOURCE_DIR}/include)
#catkin_lint: ignore_once external_interface_path
target_include_directories(yarm_nodelets SYSTEM PUBLIC ${catkin_INCLUDE_DIRS})
target_compile_options(yarm_nodelets PRIVATE -Wall -Wextra -Wpedantic)
target_link_libraries(yarm_nodelets PUBLIC yarm_perception yarm_sync ${catkin_LIBRARIES})
add_dependencies(yarm_nodelets ${${PROJECT_NAME}_EXPORTED_TARGETS} ${catkin_EXPORTED_TARGETS})

foreach(node merge_clouds cluster_assoc database perception)
  add_executable(yarm_${node}_node src/ros/${node}_node.cpp src/ros/loopback.cpp)
  set_target_properties(yarm_${node}_node PROPERTIES OUTPUT_NAME ${node})
  list(APPEND yarm_node_targets yarm_${node}_node)
endforeach()
add_executable(yarm_params_table src/ros/perception_params.cpp)
set_target_properties(yarm_params_table PROPERTIES OUTPUT_NAME perception_params)
list(APPEND yarm_node_targets yarm_params_table)
foreach(target ${yarm_node_targets})
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic)
  target_link_libraries(${target} PRIVATE yarm_nodelets)
endforeach()

install(TARGETS yarm_nodelets LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION})
install(TARGETS ${yarm_node_targets} RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})

# Plays recorded clouds and measures the answer; bench/perception_nodes.py builds and runs it.
#catkin_lint: ignore uninstalled_target
add_executable(perception_nodes_player EXCLUDE_FROM_ALL bench/perception_nodes_player.cpp)
target_compile_options(perception_nodes_player PRIVATE -Wall -Wextra -Wpedantic)
target_include_directories(perception_nodes_player PRIVATE include)
target_include_directories(perception_nodes_player SYSTEM PRIVATE ${catkin_INCLUDE_DIRS})
target_link_libraries(perception_nodes_player PRIVATE ${catkin_LIBRARIES})
add_dependencies(perception_nodes_player ${${PROJECT_NAME}_EXPORTED_TARGETS} ${catkin_EXPORTED_TARGETS})

if(CATKIN_ENABLE_TESTING)
  catkin_add_gtest(perception_edge_test test/cpp/ros/perception_edge_test.cpp)
  target_compile_options(perception_edge_test PRIVATE -Wall -Wextra -Wpedantic)
  target_link_libraries(perception_edge_test yarm_nodelets gtest_main)
  # Compiled from the sources that touch what comes from outside, all of them under the sanitizers.
  catkin_add_gtest(cloud_reader_fuzz_test
    test/cpp/ros/cloud_reader_fuzz_test.cpp src/ros/cloud_reader.cpp src/perception/crop_kernel.cpp)
  catkin_add_gtest(association_fuzz_test
    test/cpp/ros/association_fuzz_test.cpp
    src/perception/associators.cpp
    src/perception/assignment.cpp
    src/perception/attachments.cpp
    src/perception/axis_filter.cpp
    src/perception/euclidean.cpp
    src/perception/footprint.cpp
    src/perception/learned_cloud.cpp
    src/perception/hands.cpp
    src/perception/object_memory.cpp
    src/perception/object_tracks.cpp
    src/perception/occupancy.cpp
    src/perception/original_associator.cpp
    src/perception/piece.cpp
    src/perception/predict.cpp
    src/perception/remainder.cpp
    src/perception/rest_map.cpp
    src/perception/scene_model.cpp
    src/perception/sightlines.cpp
    src/perception/solids.cpp
    src/perception/stray_debris.cpp
    src/perception/surface_explainer.cpp
    src/perception/types.cpp
    src/perception/unknown_tracker.cpp
    src/perception/yarm_associator.cpp
    src/ros/conversions.cpp
    src/ros/prediction.cpp
  )
  target_link_libraries(association_fuzz_test fcl)
  foreach(test cloud_reader_fuzz_test association_fuzz_test)
    yarm_sanitize(${test} ${yarm_address_sanitizers})
  endforeach()

  # The perception process, whole, under ThreadSanitizer: test/ros/perception_threads.test plays the golden recording to it.
  #catkin_lint: ignore uninstalled_target
  add_executable(perception_under_tsan EXCLUDE_FROM_ALL src/ros/perception_node.cpp src/ros/loopback.cpp)
  foreach(library yarm_nodelets yarm_perception yarm_sync)
    get_target_property(sources ${library} SOURCES)
    target_sources(perception_under_tsan PRIVATE ${sources})
  endforeach()
  target_include_directories(perception_under_tsan SYSTEM PRIVATE ${PCL_INCLUDE_DIRS})
  target_compile_options(perception_under_tsan PRIVATE -ffp-contract=off -fno-math-errno)
  yarm_sanitize(perception_under_tsan thread)
  target_link_libraries(perception_under_tsan ${PCL_LIBRARIES} fcl)
  add_dependencies(tests perception_under_tsan)
endif()
