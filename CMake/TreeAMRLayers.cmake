# The libraries in the order of their dependencies: Core <- Reader <- Rendering <- Plugin/Representations.
# Included by a build of our own and from ParaView's source tree.

# Before 1.0 a new minor version may break what was linked to the one before.
string(REGEX MATCH "^[0-9]+[.][0-9]+" TREEAMR_SOVERSION "${TREEAMR_VERSION}")

include(CMake/TreeAMRPrecompiledHeaders.cmake)
add_subdirectory(Core)
if (TREEAMR_CORE_ONLY)
  return ()
endif ()

set(modules TreeAMR::Reader TreeAMR::Rendering)
set(module_files
  "${CMAKE_CURRENT_SOURCE_DIR}/Reader/vtk.module"
  "${CMAKE_CURRENT_SOURCE_DIR}/Rendering/vtk.module")
if (TREEAMR_WITH_PLUGIN OR DEFINED _paraview_build_plugin)
  list(APPEND modules TreeAMR::Representations)
  list(APPEND module_files "${CMAKE_CURRENT_SOURCE_DIR}/Plugin/Representations/vtk.module")
endif ()
vtk_module_scan(
  MODULE_FILES ${module_files}
  REQUEST_MODULES ${modules}
  PROVIDES_MODULES provided_modules
  REQUIRES_MODULES required_modules
  HIDE_MODULES_FROM_CACHE ON
  ENABLE_TESTS OFF)
foreach (module IN LISTS required_modules)
  if (NOT TARGET ${module})
    message(FATAL_ERROR "VTK or ParaView lacks the module ${module}.")
  endif ()
endforeach ()
vtk_module_build(
  MODULES ${provided_modules}
  PACKAGE TreeAMR
  VERSION "${TREEAMR_VERSION}"
  SOVERSION "${TREEAMR_SOVERSION}"
  INSTALL_EXPORT TreeAMR
  HEADERS_DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/treeamr"
  CMAKE_DESTINATION "${CMAKE_INSTALL_LIBDIR}/cmake/TreeAMR"
  TEST_DIRECTORY_NAME NONE)
