# What the CMake files of VTK's and ParaView's packages leave undone, for the build and for whoever uses what it installed.

# treeamr_package_folder(<variable> <package>): where find_package() will take the package from.
function (treeamr_package_folder variable package)
  set(folder "${${package}_DIR}")
  if (NOT folder)
    # Too new a version: its files are found, but not loaded.
    find_package(${package} 999999 QUIET)
    if (${package}_CONSIDERED_CONFIGS)
      list(GET ${package}_CONSIDERED_CONFIGS 0 file)
      cmake_path(GET file PARENT_PATH folder)
    endif ()
  endif ()
  set(${variable} "${folder}" PARENT_SCOPE)
endfunction ()

# treeamr_renamed_module(<variable> <folder> <module>): the path of the module without .so below the prefix of the CMake
# files in the folder, if there is none with .so, becomes the path of what is there.
function (treeamr_renamed_module variable folder module)
  set(${variable} "" PARENT_SCOPE)
  set(prefix "")
  set(above "${folder}")
  while (NOT above STREQUAL prefix)
    set(prefix "${above}")
    file(GLOB renamed "${prefix}/${module}.cpython-*.so")
    if (EXISTS "${prefix}/${module}.so")
      return ()
    elseif (renamed)
      list(GET renamed 0 renamed)
      cmake_path(RELATIVE_PATH renamed BASE_DIRECTORY "${prefix}")
      set(${variable} "${renamed}" PARENT_SCOPE)
      return ()
    endif ()
    cmake_path(GET prefix PARENT_PATH above)
  endwhile ()
endfunction ()

# treeamr_define_python_targets(<package>): to be called before find_package(<package>).
#
# A distribution may have renamed the Python modules. Debian 13's CMake files name vtkCommonCore.so, its packages have
# vtkCommonCore.cpython-313-x86_64-linux-gnu.so, and find_package() ends with an error. Targets that exist already it
# leaves alone, so corrected copies of the files that make them are included before it.
function (treeamr_define_python_targets package)
  treeamr_package_folder(folder ${package})
  if (NOT folder)
    return ()
  endif ()
  # ParaView's own VTK, which is in a folder of its, comes first.
  file(GLOB vtk "${folder}/vtk/*Python*-targets.cmake")
  file(GLOB files "${folder}/*Python*-targets.cmake")
  foreach (file IN LISTS vtk files)
    cmake_path(GET file PARENT_PATH folder)
    cmake_path(GET file STEM name)
    set(copies "${CMAKE_BINARY_DIR}/CMakeFiles/renamed/${package}")
    file(GLOB configurations "${folder}/${name}-*.cmake")
    set(is_renamed OFF)
    foreach (configuration IN LISTS configurations)
      file(READ "${configuration}" text)
      if (text MATCHES "_IMPORT_PREFIX}/([^\"]+)[.]so\"")
        set(module "${CMAKE_MATCH_1}")
        treeamr_renamed_module(renamed "${folder}" "${module}")
        if (renamed)
          set(is_renamed ON)
          string(LENGTH "${module}" length)
          string(SUBSTRING "${renamed}" ${length} -1 suffix)
          string(REGEX REPLACE "(_IMPORT_PREFIX}/[^\"]+)[.]so\"" "\\1${suffix}\"" text "${text}")
        endif ()
      endif ()
      cmake_path(GET configuration FILENAME copy)
      file(WRITE "${copies}/${copy}" "${text}")
    endforeach ()
    if (is_renamed)
      file(READ "${file}" text)
      string(REPLACE "\${CMAKE_CURRENT_LIST_FILE}" "${file}" text "${text}")
      file(WRITE "${copies}/${name}.cmake" "${text}")
      include("${copies}/${name}.cmake")
    endif ()
  endforeach ()
endfunction ()

# treeamr_define_linked_targets(): to be called after it.
#
# Some of ParaView's libraries are linked to targets of HDF5 and NetCDF, which find_package() looks for only where these are
# components of VTK's. Linking to ParaView needs no more of them than their names.
function (treeamr_define_linked_targets)
  get_property(libraries DIRECTORY PROPERTY IMPORTED_TARGETS)
  foreach (library IN LISTS libraries)
    get_target_property(others ${library} INTERFACE_LINK_LIBRARIES)
    list(FILTER others INCLUDE REGEX "^[A-Za-z0-9_]+::[A-Za-z0-9_]+$")
    foreach (other IN LISTS others)
      if (NOT TARGET ${other})
        add_library(${other} INTERFACE IMPORTED)
      endif ()
    endforeach ()
  endforeach ()
endfunction ()
