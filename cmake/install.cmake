# What the install space holds beside the targets, which install themselves where they are made.
# catkin_lint does not expand the glob.
#catkin_lint: ignore argument_error
file(GLOB yarm_scripts CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/scripts/*)
string(FIND "${CATKIN_DEVEL_PREFIX}/" "${CMAKE_CURRENT_SOURCE_DIR}/" yarm_devel_inside)
if(yarm_devel_inside EQUAL 0)
  # The devel space lies in the checkout: rosrun finds scripts/ itself, and a relay beside it would be ambiguous.
  install(PROGRAMS ${yarm_scripts} DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
  foreach(yarm_script ${yarm_scripts})
    get_filename_component(yarm_name ${yarm_script} NAME)
    install(CODE "
      set(file \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CATKIN_PACKAGE_BIN_DESTINATION}/${yarm_name}\")
      file(READ \"\${file}\" text)
      string(REGEX REPLACE \"^#![^\\n]*\" \"#!${PYTHON_EXECUTABLE}\" text \"\${text}\")
      file(WRITE \"\${file}\" \"\${text}\")")
  endforeach()
  catkin_add_env_hooks(50.yarm_python SHELLS sh DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/cmake/env-hooks SKIP_INSTALL)
else()
  catkin_install_python(PROGRAMS ${yarm_scripts} DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
endif()
install(DIRECTORY include/${PROJECT_NAME}/ DESTINATION ${CATKIN_PACKAGE_INCLUDE_DESTINATION})
install(DIRECTORY launch config scenes tags urdf docs web DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
install(FILES nodelets.xml DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
