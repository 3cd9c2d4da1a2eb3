# The complete search over the fleet's configurations, loaded by yarm.planning.fleet.joint_native; plain C++ with a C interface.
add_library(yarm_joint SHARED src/joint/c_api.cpp src/joint/crowd.cpp src/joint/exchange.cpp src/joint/fleet.cpp
  src/joint/masks.cpp src/joint/pairs.cpp src/joint/permutations.cpp src/joint/search.cpp src/joint/shorten.cpp src/joint/solver.cpp)
target_include_directories(yarm_joint PUBLIC ${CMAKE_CURRENT_SOURCE_DIR}/include)
target_compile_options(yarm_joint PRIVATE -Wall -Wextra -Wpedantic -O3)
set_target_properties(yarm_joint PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${CATKIN_DEVEL_PREFIX}/lib)
install(TARGETS yarm_joint LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION})
if(CATKIN_ENABLE_TESTING)
  catkin_add_gtest(joint_permutations_test test/cpp/joint/joint_permutations_test.cpp)
  target_compile_options(joint_permutations_test PRIVATE -Wall -Wextra -Wpedantic)
  target_link_libraries(joint_permutations_test yarm_joint gtest_main)
endif()
