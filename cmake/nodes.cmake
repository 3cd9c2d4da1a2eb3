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
