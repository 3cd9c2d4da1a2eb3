# Programs compiled whole, with all of this project's sources that they use, under sanitizers of the compiler.
set(yarm_address_sanitizers address,undefined,float-cast-overflow)

function(yarm_sanitize target sanitizers)
  target_include_directories(${target} PRIVATE include src/perception test/support)
  target_include_directories(${target} SYSTEM PRIVATE ${catkin_INCLUDE_DIRS} ${EIGEN3_INCLUDE_DIRS})
  target_compile_options(${target} PRIVATE -O1 -g1 -fsanitize=${sanitizers} -fno-sanitize-recover=all)
  target_link_options(${target} PRIVATE -fsanitize=${sanitizers})
  target_link_libraries(${target} ${catkin_LIBRARIES})
  add_dependencies(${target} ${${PROJECT_NAME}_EXPORTED_TARGETS} ${catkin_EXPORTED_TARGETS})
endfunction()
