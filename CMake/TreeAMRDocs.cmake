# The target `docs`: API pages in docs/html of the build folder. Not as a part of another project, which may have its own.
find_program(DOXYGEN_EXECUTABLE doxygen)
if (DOXYGEN_EXECUTABLE AND PROJECT_IS_TOP_LEVEL)
  set(docs "${PROJECT_BINARY_DIR}/docs")
  get_property(headers GLOBAL PROPERTY TREEAMR_API_HEADERS)
  list(TRANSFORM headers PREPEND "${PROJECT_SOURCE_DIR}/Core/")
  file(GLOB included "${PROJECT_SOURCE_DIR}/Core/include/treeamr/*.h")
  list(APPEND headers ${included})
  foreach (path IN ITEMS Reader Rendering/Mappers CMake/Doxygen/mainpage.dox)
    list(APPEND headers "${PROJECT_SOURCE_DIR}/${path}")
  endforeach ()
  list(TRANSFORM headers REPLACE ".+" "\"\\0\"")
  list(JOIN headers " " input)
  configure_file(CMake/Doxygen/Doxyfile.in "${PROJECT_BINARY_DIR}/CMakeFiles/Doxyfile" @ONLY)
  add_custom_target(docs
    COMMAND "${CMAKE_COMMAND}" -E rm -rf "${docs}"
    COMMAND "${DOXYGEN_EXECUTABLE}" "${PROJECT_BINARY_DIR}/CMakeFiles/Doxyfile"
    VERBATIM)
endif ()
