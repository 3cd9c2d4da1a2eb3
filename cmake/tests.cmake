# rostests for those who use catkin's own runner; `make test` runs the same files through pytest.
find_package(rostest REQUIRED)
file(GLOB yarm_rostests CONFIGURE_DEPENDS
  RELATIVE ${CMAKE_CURRENT_SOURCE_DIR}
  ${CMAKE_CURRENT_SOURCE_DIR}/test/ros/*.test
  ${CMAKE_CURRENT_SOURCE_DIR}/test/system/*.test
)
foreach(yarm_rostest ${yarm_rostests})
  add_rostest(${yarm_rostest})
endforeach()
