# The ROS-free library that brings measurements of different times together.
add_library(yarm_sync src/sync/seed_buffer.cpp)
target_include_directories(yarm_sync PUBLIC ${CMAKE_CURRENT_SOURCE_DIR}/include)
target_compile_options(yarm_sync PRIVATE -Wall -Wextra -Wpedantic)
target_link_libraries(yarm_sync PUBLIC yarm_perception)
install(TARGETS yarm_sync
  ARCHIVE DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
  LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
)

if(CATKIN_ENABLE_TESTING)
  foreach(test set_assembler_test hand_words_test)
    catkin_add_gtest(${test} test/cpp/sync/${test}.cpp)
    target_compile_options(${test} PRIVATE -Wall -Wextra -Wpedantic)
    target_link_libraries(${test} yarm_sync gtest_main)
  endforeach()
endif()
