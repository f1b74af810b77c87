# The Python package treeamr: treeamr.vtkTreeAMRReader and treeamr.vtkTreeAMRRendering.

set(TREEAMR_PYTHON_DIR "${CMAKE_INSTALL_LIBDIR}/python3/dist-packages")
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

set(init "${CMAKE_BINARY_DIR}/${TREEAMR_PYTHON_DIR}/treeamr/__init__.py")
configure_file(Plugin/Python/__init__.py.in "${init}" @ONLY)
install(FILES "${init}" DESTINATION "${TREEAMR_PYTHON_DIR}/treeamr")
