# Distances of the youBot's arm, loaded by yarm.manipulation.obstacles.clearance_native; FCL with a C interface.
find_package(fcl 0.7 REQUIRED)
find_package(Eigen3 REQUIRED)
add_library(yarm_clearance SHARED src/clearance/clearance.cpp)
target_include_directories(yarm_clearance PUBLIC ${CMAKE_CURRENT_SOURCE_DIR}/include)
target_compile_options(yarm_clearance PRIVATE -Wall -Wextra -Wpedantic -O3)
target_link_libraries(yarm_clearance PRIVATE fcl Eigen3::Eigen)
set_target_properties(yarm_clearance PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${CATKIN_DEVEL_PREFIX}/lib)
install(TARGETS yarm_clearance LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION})
