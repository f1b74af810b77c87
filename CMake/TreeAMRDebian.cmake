# Debian packages by CPack, from a build for the prefix /usr (`make package`): treeamr and treeamr-dev.
#
# What the libraries depend on is computed (dpkg-shlibdeps). ParaView's programs load the plugins of the files that paraview.conf
# lists: so no environment is needed. Debian 12 has none, and its programs look for it beside them. Those of ParaView are listed,
# too, for it then looks for them nowhere else. From Debian 13 on paraview has one in its library folder, which is diverted.

if (NOT PROJECT_IS_TOP_LEVEL OR NOT CMAKE_INSTALL_PREFIX STREQUAL "/usr" OR NOT TREEAMR_WITH_PLUGIN)
  return ()
endif ()

set(maintainer "The TreeAMR authors <maintainers@treeamr.example>")
set(revision 1)

cmake_path(GET TREEAMR_PLUGIN_DIR PARENT_PATH folder)
set(conf "/usr/${folder}/paraview.conf")
set(is_diverted OFF)
if (EXISTS "${conf}")
  set(is_diverted ON)
  file(STRINGS "${conf}" lists)
  set(list "plugins/treeamr.plugins.xml")
  list(REMOVE_ITEM lists "${list}") # when the package is installed here
else ()
  set(folder "${CMAKE_INSTALL_BINDIR}")
  file(RELATIVE_PATH plugins "${CMAKE_INSTALL_FULL_BINDIR}" "/usr/${TREEAMR_PLUGIN_DIR}")
  set(lists "${plugins}/paraview.plugins.xml")
  set(list "${plugins}/treeamr.plugins.xml")
endif ()
list(JOIN lists "\n" lists)
file(WRITE "${CMAKE_BINARY_DIR}/CMakeFiles/paraview.conf" "${lists}\n${list}\n")
install(FILES "${CMAKE_BINARY_DIR}/CMakeFiles/paraview.conf" DESTINATION "${folder}")

# What Debian's policy wants in each package (chapters 4.4 and 12.5).
file(READ LICENSE license)
string(REGEX REPLACE "\n\n" "\n.\n" license "${license}")
string(STRIP "${license}" license)
string(REGEX REPLACE "\n" "\n " license "${license}")
file(WRITE "${CMAKE_BINARY_DIR}/CMakeFiles/copyright"
  "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\nUpstream-Name: TreeAMR\n\n"
  "Files: *\nCopyright: 2026 The TreeAMR authors\nLicense: BSD-3-clause\n ${license}\n")
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(WRITE "${CMAKE_BINARY_DIR}/CMakeFiles/changelog.Debian"
  "treeamr (${TREEAMR_VERSION}-${revision}) unstable; urgency=medium\n\n  * Release; see CHANGELOG.md.\n\n"
  " -- ${maintainer}  ${date}\n")
configure_file(CHANGELOG.md "${CMAKE_BINARY_DIR}/CMakeFiles/changelog" COPYONLY)
foreach (file IN ITEMS changelog changelog.Debian)
  execute_process(
    COMMAND gzip --best --no-name --force --keep "${CMAKE_BINARY_DIR}/CMakeFiles/${file}" COMMAND_ERROR_IS_FATAL ANY)
endforeach ()
foreach (package IN ITEMS treeamr treeamr-dev)
  set(component runtime)
  if (package STREQUAL "treeamr-dev")
    set(component development)
  endif ()
  install(
    FILES
      "${CMAKE_BINARY_DIR}/CMakeFiles/copyright"
      "${CMAKE_BINARY_DIR}/CMakeFiles/changelog.gz"
      "${CMAKE_BINARY_DIR}/CMakeFiles/changelog.Debian.gz"
    DESTINATION "share/doc/${package}"
    COMPONENT ${component})
endforeach ()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME treeamr)
set(CPACK_PACKAGE_VERSION "${TREEAMR_VERSION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL runtime python development)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_COMPONENT_RUNTIME_GROUP run)
set(CPACK_COMPONENT_PYTHON_GROUP run)
set(CPACK_COMPONENT_DEVELOPMENT_GROUP dev)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE ${revision})
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "${maintainer}")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_RUN_PACKAGE_NAME treeamr)
set(CPACK_DEBIAN_RUN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_RUN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_RUN_PACKAGE_DEPENDS "python3, paraview, python3-paraview, python3-numpy")
# CPack's own list of shared libraries has Python's modules, too, and it has no trigger.
set(libraries)
foreach (library IN ITEMS TreeAMRCore vtkTreeAMRReader vtkTreeAMRRendering vtkTreeAMRRepresentations)
  string(APPEND libraries "lib${library} ${TREEAMR_SOVERSION} treeamr (>= ${TREEAMR_SOVERSION})\n")
endforeach ()
file(WRITE "${CMAKE_BINARY_DIR}/CMakeFiles/shlibs" "${libraries}")
file(WRITE "${CMAKE_BINARY_DIR}/CMakeFiles/triggers" "activate-noawait ldconfig\n")
set(control shlibs triggers postinst prerm)
# What Python compiles goes with the package, too, as dh_python3 has it.
set(script "#!/bin/sh\nset -e\nif command -v py3")
file(WRITE "${CMAKE_BINARY_DIR}/CMakeFiles/postinst"
  "${script}compile > /dev/null; then\n  py3compile -p treeamr\nfi\n")
file(WRITE "${CMAKE_BINARY_DIR}/CMakeFiles/prerm"
  "${script}clean > /dev/null; then\n  py3clean -p treeamr\nfi\n")
if (is_diverted)
  list(APPEND control preinst postrm)
  set(divert "dpkg-divert --package treeamr --rename --divert ${conf}.paraview")
  file(WRITE "${CMAKE_BINARY_DIR}/CMakeFiles/preinst"
    "#!/bin/sh\nset -e\nif [ \"$1\" != abort-upgrade ]; then\n  ${divert} --add ${conf}\nfi\n")
  file(WRITE "${CMAKE_BINARY_DIR}/CMakeFiles/postrm"
    "#!/bin/sh\nset -e\ncase \"$1\" in\n  remove | abort-install | disappear)\n    ${divert} --remove ${conf}\n    ;;\nesac\n")
endif ()
list(TRANSFORM control PREPEND "${CMAKE_BINARY_DIR}/CMakeFiles/")
set(CPACK_DEBIAN_RUN_PACKAGE_CONTROL_EXTRA "${control}")
set(CPACK_DEBIAN_RUN_DESCRIPTION
"ray tracing of octree AMR data in ParaView
Volumes and implicit isosurfaces of data on octrees (p4est, deal.II, hyper tree
grids) as representations, readers, filters and a Python package.")
set(CPACK_DEBIAN_DEV_PACKAGE_NAME treeamr-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
  "treeamr (= ${TREEAMR_VERSION}-${revision}), paraview-dev, libtbb-dev")
set(CPACK_DEBIAN_DEV_DESCRIPTION
"ray tracing of octree AMR data: development files
Headers and CMake package for C++ programs with or without VTK.")
include(CPack)
