# The perception nodes: nodelets, and the same classes as standalone nodes.
if(NOT TARGET yarm_perception)
  return()
endif()
add_library(yarm_nodelets SHARED
  src/nodes/cloud_reader.cpp
  src/nodes/cluster_assoc.cpp
  src/nodes/conversions.cpp
  src/nodes/database.cpp
  src/nodes/executor.cpp
  src/nodes/in_process.cpp
  src/nodes/merge_clouds.cpp
  src/nodes/nodelets.cpp
  src/nodes/report.cpp
  src/nodes/seed_buffer.cpp
  src/nodes/tf_source.cpp
)
target_include_directories(yarm_nodelets PUBLIC ${CMAKE_CURRENT_SOURCE_DIR}/include)
#catkin_lint: ignore_once external_interface_path
target_include_directories(yarm_nodelets SYSTEM PUBLIC ${catkin_INCLUDE_DIRS})
target_compile_options(yarm_nodelets PRIVATE -Wall -Wextra -Wpedantic)
target_link_libraries(yarm_nodelets PUBLIC yarm_perception ${catkin_LIBRARIES})
add_dependencies(yarm_nodelets ${${PROJECT_NAME}_EXPORTED_TARGETS} ${catkin_EXPORTED_TARGETS})

foreach(node merge_clouds cluster_assoc database perception)
  add_executable(yarm_${node}_node src/nodes/${node}_node.cpp)
  set_target_properties(yarm_${node}_node PROPERTIES OUTPUT_NAME ${node})
  list(APPEND yarm_node_targets yarm_${node}_node)
endforeach()
add_executable(yarm_params_table src/nodes/perception_params.cpp)
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
  foreach(test set_assembler_test perception_edge_test)
    catkin_add_gtest(${test} test/cpp/${test}.cpp)
    target_compile_options(${test} PRIVATE -Wall -Wextra -Wpedantic)
    target_link_libraries(${test} yarm_nodelets gtest_main)
  endforeach()
  # Compiled from the sources that touch a cloud's bytes, all of them under the sanitizers.
  catkin_add_gtest(cloud_reader_fuzz_test
    test/cpp/cloud_reader_fuzz_test.cpp src/nodes/cloud_reader.cpp src/perception/crop_kernel.cpp)
  target_include_directories(cloud_reader_fuzz_test PRIVATE include src/perception)
  target_include_directories(cloud_reader_fuzz_test SYSTEM PRIVATE ${catkin_INCLUDE_DIRS} ${EIGEN3_INCLUDE_DIRS})
  target_compile_options(cloud_reader_fuzz_test PRIVATE -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all)
  target_link_options(cloud_reader_fuzz_test PRIVATE -fsanitize=address,undefined)
  target_link_libraries(cloud_reader_fuzz_test ${catkin_LIBRARIES})
  add_dependencies(cloud_reader_fuzz_test ${${PROJECT_NAME}_EXPORTED_TARGETS} ${catkin_EXPORTED_TARGETS})
endif()
