# The simulated cameras' ray casting, loaded by yarm.sim.sensors.rays_native; plain C++ with a C interface.
add_library(yarm_rays SHARED src/rays/rays.cpp)
target_include_directories(yarm_rays PUBLIC ${CMAKE_CURRENT_SOURCE_DIR}/include)
target_compile_options(yarm_rays PRIVATE -Wall -Wextra -Wpedantic -O3 -fno-math-errno -fno-trapping-math)
set_target_properties(yarm_rays PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${CATKIN_DEVEL_PREFIX}/lib)
install(TARGETS yarm_rays LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION})
