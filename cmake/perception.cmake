# The ROS-free perception library: Eigen and PCL (and FCL for the narrow phase of predict_new_state).
find_package(Eigen3 REQUIRED)
find_package(PCL 1.12 REQUIRED COMPONENTS common filters search segmentation)
find_package(fcl 0.7 REQUIRED)

add_library(yarm_perception
  src/perception/associators.cpp
  src/perception/assignment.cpp
  src/perception/attachments.cpp
  src/perception/axis_filter.cpp
  src/perception/backends.cpp
  src/perception/camera_watch.cpp
  src/perception/cell_views.cpp
  src/perception/crop_kernel.cpp
  src/perception/depth_view.cpp
  src/perception/depth_windows.cpp
  src/perception/euclidean.cpp
  src/perception/footprint.cpp
  src/perception/fused_backend.cpp
  src/perception/learned_cloud.cpp
  src/perception/hands.cpp
  src/perception/hiders.cpp
  src/perception/object_memory.cpp
  src/perception/object_tracks.cpp
  src/perception/occupancy.cpp
  src/perception/original_associator.cpp
  src/perception/pcl_backend.cpp
  src/perception/picture_watch.cpp
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
  src/perception/view.cpp
  src/perception/visibility.cpp
  src/perception/yarm_associator.cpp
)
target_include_directories(yarm_perception PUBLIC ${CMAKE_CURRENT_SOURCE_DIR}/include)
#catkin_lint: ignore_once external_interface_path
target_include_directories(yarm_perception SYSTEM PUBLIC ${EIGEN3_INCLUDE_DIRS} PRIVATE ${PCL_INCLUDE_DIRS})
target_link_libraries(yarm_perception PRIVATE ${PCL_LIBRARIES} fcl)
# No fused multiply-add: both back ends must round alike.
target_compile_options(yarm_perception PRIVATE
  -O3 -Wall -Wextra -Wpedantic -ffp-contract=off -fno-math-errno -fno-semantic-interposition
)
install(TARGETS yarm_perception
  ARCHIVE DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
  LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
)

if(CATKIN_ENABLE_TESTING)
  # Synthetic camera sets with their truth; for tests and benchmarks.
  add_library(yarm_scene_factory STATIC EXCLUDE_FROM_ALL
    test/support/association_score.cpp
    test/support/cell_bodies.cpp
    test/support/map_score.cpp
    test/support/scene_factory.cpp
    test/support/scored_sequences.cpp
  )
  target_include_directories(yarm_scene_factory PUBLIC test/support)
  target_compile_options(yarm_scene_factory PRIVATE -O3 -Wall -Wextra -Wpedantic)
  target_link_libraries(yarm_scene_factory PUBLIC yarm_perception)

  set_target_properties(yarm_scene_factory PROPERTIES POSITION_INDEPENDENT_CODE ON)

  # The same from Python (test/support/perception_chain.py).
  add_library(yarm_scene_factory_c SHARED EXCLUDE_FROM_ALL test/support/scene_factory_c.cpp)
  target_compile_options(yarm_scene_factory_c PRIVATE -O3 -Wall -Wextra -Wpedantic)
  target_link_libraries(yarm_scene_factory_c PRIVATE yarm_scene_factory)
  add_dependencies(tests yarm_scene_factory_c)

  catkin_add_gtest(perception_merge_test test/cpp/perception/perception_merge_test.cpp)
  target_include_directories(perception_merge_test SYSTEM PRIVATE ${PCL_INCLUDE_DIRS})
  target_link_libraries(perception_merge_test yarm_scene_factory ${PCL_LIBRARIES} gtest_main)
  foreach(test
      perception_association_test
      perception_camera_watch_test
      perception_filter_test
      perception_footprint_test
      perception_hands_test
      perception_hiders_test
      perception_map_test
      perception_original_test
      perception_unknown_test
      perception_picture_watch_test
      perception_piece_test
      perception_tracks_test
      perception_view_test
      perception_visibility_test)
    catkin_add_gtest(${test} test/cpp/perception/${test}.cpp)
    target_link_libraries(${test} yarm_scene_factory gtest_main)
  endforeach()
  target_include_directories(perception_filter_test PRIVATE src/perception)
  target_include_directories(perception_footprint_test PRIVATE src/perception)
  target_include_directories(perception_map_test PRIVATE src/perception)
  target_include_directories(perception_tracks_test PRIVATE src/perception)
  target_include_directories(perception_unknown_test PRIVATE src/perception)
  target_include_directories(perception_visibility_test PRIVATE src/perception)
endif()

if(TARGET yarm_scene_factory)
  # On demand: make perception_core_bench
  #catkin_lint: ignore uninstalled_target
  add_executable(perception_core_bench EXCLUDE_FROM_ALL bench/perception_core.cpp)
  target_compile_options(perception_core_bench PRIVATE -O3 -Wall -Wextra -Wpedantic)
  target_link_libraries(perception_core_bench PRIVATE yarm_scene_factory)
  # On demand: make robustness_bench
  #catkin_lint: ignore uninstalled_target
  add_executable(robustness_bench EXCLUDE_FROM_ALL bench/robustness.cpp)
  target_compile_options(robustness_bench PRIVATE -O3 -Wall -Wextra -Wpedantic)
  target_link_libraries(robustness_bench PRIVATE yarm_scene_factory)
endif()
