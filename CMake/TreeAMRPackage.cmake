# find_package(TreeAMR), and the environment that makes python and ParaView find everything.

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/TreeAMR")
if (NOT TARGET TreeAMR::Reader)
  # Otherwise vtk_module_build() has installed the targets.
  install(
    EXPORT TreeAMR
    NAMESPACE TreeAMR::
    DESTINATION "${package_dir}"
    FILE TreeAMR-targets.cmake)
endif ()
include(CMakePackageConfigHelpers)
configure_package_config_file(
  CMake/TreeAMRConfig.cmake.in "${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/TreeAMRConfig.cmake"
  INSTALL_DESTINATION "${package_dir}"
  NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(
  "${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/TreeAMRConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(
  FILES
    "${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/TreeAMRConfig.cmake"
    "${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/TreeAMRConfigVersion.cmake"
  DESTINATION "${package_dir}")
install(FILES LICENSE DESTINATION "${CMAKE_INSTALL_DOCDIR}")

# treeamr_env(<variable> <root>): the text of env.sh for a build folder or a prefix.
function (treeamr_env variable root)
  set(text "# `. env.sh`: after it pvpython, pvbatch and paraview find the package treeamr and the plugin\n")
  set(PYTHONPATH "${TREEAMR_PYTHON_DIR}")
  set(PV_PLUGIN_PATH "${TREEAMR_PLUGIN_DIR}")
  foreach (name IN ITEMS PYTHONPATH PV_PLUGIN_PATH)
    if (${name})
      string(APPEND text "export ${name}=\"${root}/${${name}}\${${name}:+:$${name}}\"\n")
    endif ()
  endforeach ()
  set(${variable} "${text}" PARENT_SCOPE)
endfunction ()

treeamr_env(text "${CMAKE_BINARY_DIR}")
file(CONFIGURE OUTPUT "${CMAKE_BINARY_DIR}/env.sh" CONTENT "${text}" @ONLY)
# The prefix is known at installation only.
treeamr_env(text "@CMAKE_INSTALL_PREFIX@")
set(env "${CMAKE_BINARY_DIR}/CMakeFiles/env.sh")
file(WRITE "${env}.in" "${text}")
install(CODE "configure_file(\"${env}.in\" \"${env}\" @ONLY)")
install(FILES "${env}" DESTINATION "${CMAKE_INSTALL_DATADIR}/treeamr")
