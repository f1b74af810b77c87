# find_package(TreeAMR), and the environment that makes python and ParaView find everything.

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/TreeAMR")
if (NOT TARGET TreeAMR::Reader)
  # Otherwise vtk_module_build() has installed the targets.
  install(
    EXPORT TreeAMR
    NAMESPACE TreeAMR::
    DESTINATION "${package_dir}"
    FILE TreeAMR-targets.cmake
    COMPONENT development)
endif ()
configure_file(CMake/OwnHeaders.cmake.in "${PROJECT_BINARY_DIR}/CMakeFiles/OwnHeaders.cmake" @ONLY)
install(SCRIPT "${PROJECT_BINARY_DIR}/CMakeFiles/OwnHeaders.cmake" COMPONENT development)

# What programs without VTK link, for the package's own find_package() and pkg-config.
get_target_property(type TreeAMRCore TYPE)
set(TREEAMR_CORE_IS_STATIC OFF)
if (type STREQUAL "STATIC_LIBRARY")
  set(TREEAMR_CORE_IS_STATIC ON)
endif ()
include(CMakePackageConfigHelpers)
# treeamr_package(<folder> <prefix> <destination>): the files that find_package() reads, for a build folder or an installation.
function (treeamr_package folder prefix destination)
  configure_package_config_file(
    CMake/TreeAMRConfig.cmake.in "${folder}/TreeAMRConfig.cmake"
    INSTALL_PREFIX "${prefix}"
    INSTALL_DESTINATION "${destination}"
    NO_SET_AND_CHECK_MACRO
    NO_CHECK_REQUIRED_COMPONENTS_MACRO)
  write_basic_package_version_file("${folder}/TreeAMRConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
endfunction ()
treeamr_package("${PROJECT_BINARY_DIR}/CMakeFiles/package" "${CMAKE_INSTALL_PREFIX}" "${package_dir}")
install(
  FILES
    "${PROJECT_BINARY_DIR}/CMakeFiles/package/TreeAMRConfig.cmake"
    "${PROJECT_BINARY_DIR}/CMakeFiles/package/TreeAMRConfigVersion.cmake"
    CMake/TreeAMRVTKTargets.cmake
  DESTINATION "${package_dir}"
  COMPONENT development)
# vtk_module_build() writes the targets beside these.
treeamr_package("${PROJECT_BINARY_DIR}/${package_dir}" "${PROJECT_BINARY_DIR}" "${package_dir}")
configure_file(CMake/TreeAMRVTKTargets.cmake "${PROJECT_BINARY_DIR}/${package_dir}/TreeAMRVTKTargets.cmake" COPYONLY)
if (NOT TARGET TreeAMR::Reader)
  export(EXPORT TreeAMR NAMESPACE TreeAMR:: FILE "${PROJECT_BINARY_DIR}/${package_dir}/TreeAMR-targets.cmake")
endif ()

file(RELATIVE_PATH back "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
configure_file(CMake/treeamr.pc.in "${PROJECT_BINARY_DIR}/CMakeFiles/treeamr.pc" @ONLY)
install(
  FILES "${PROJECT_BINARY_DIR}/CMakeFiles/treeamr.pc"
  DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig"
  COMPONENT development)
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

treeamr_env(text "${PROJECT_BINARY_DIR}")
file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/env.sh" CONTENT "${text}" @ONLY)
# The prefix is known at installation only.
treeamr_env(text "@CMAKE_INSTALL_PREFIX@")
set(env "${PROJECT_BINARY_DIR}/CMakeFiles/env.sh")
file(WRITE "${env}.in" "${text}")
install(CODE "configure_file(\"${env}.in\" \"${env}\" @ONLY)")
install(FILES "${env}" DESTINATION "${CMAKE_INSTALL_DATADIR}/treeamr")
