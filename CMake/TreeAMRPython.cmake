# The Python package treeamr: the wrapped classes, and the functions for numpy around them.

if (NOT TREEAMR_PYTHON_DIR)
  set(TREEAMR_PYTHON_DIR "${CMAKE_INSTALL_LIBDIR}/python3/dist-packages")
endif ()
# From <python>/treeamr/ back to the libraries.
file(RELATIVE_PATH back "/${TREEAMR_PYTHON_DIR}/treeamr" "/${CMAKE_INSTALL_LIBDIR}")
set(CMAKE_INSTALL_RPATH "$ORIGIN/${back}")
vtk_module_wrap_python(
  MODULES TreeAMR::Reader TreeAMR::Rendering
  TARGET TreeAMR::Python
  PYTHON_PACKAGE treeamr
  MODULE_DESTINATION "${TREEAMR_PYTHON_DIR}"
  CMAKE_DESTINATION "${CMAKE_INSTALL_LIBDIR}/cmake/TreeAMR"
  INSTALL_HEADERS OFF)
set(CMAKE_INSTALL_RPATH "$ORIGIN")

set(package "${CMAKE_BINARY_DIR}/${TREEAMR_PYTHON_DIR}/treeamr")
configure_file(Plugin/Python/__init__.py.in "${package}/__init__.py" @ONLY)
set(files "${package}/__init__.py")
foreach (module IN ITEMS arrays grids pictures sampling updates)
  configure_file("Plugin/Python/${module}.py" "${package}/${module}.py" COPYONLY)
  list(APPEND files "${package}/${module}.py")
endforeach ()
install(FILES ${files} DESTINATION "${TREEAMR_PYTHON_DIR}/treeamr" COMPONENT python)
