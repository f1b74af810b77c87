# Headers of others, parsed once for many sources. Off unless a preset asks for it, because with them a source compiles that
# forgot an #include.
option(TREEAMR_PRECOMPILE_HEADERS "Precompile the headers of other libraries; hides missing #include lines" OFF)

# treeamr_precompile_headers(<target> <kind> [<header>...])
#
# The first target of a kind has the headers compiled, the others take them from there: they need the same compiler flags and
# all of its definitions, and may have more.
function (treeamr_precompile_headers target kind)
  if (NOT TREEAMR_PRECOMPILE_HEADERS)
    return ()
  endif ()
  get_property(first GLOBAL PROPERTY TREEAMR_PRECOMPILED_${kind})
  if (first)
    target_precompile_headers(${target} REUSE_FROM ${first})
    return ()
  endif ()
  set_property(GLOBAL PROPERTY TREEAMR_PRECOMPILED_${kind} ${target})
  target_precompile_headers(${target} PRIVATE
    <algorithm> <array> <atomic> <bit> <cmath> <cstdint> <cstring> <functional> <limits> <map> <memory> <optional>
    <random> <set> <span> <sstream> <string> <tuple> <utility> <vector>
    <oneapi/tbb/blocked_range.h> <oneapi/tbb/enumerable_thread_specific.h> <oneapi/tbb/parallel_for.h>
    <oneapi/tbb/parallel_invoke.h> <oneapi/tbb/parallel_reduce.h> <oneapi/tbb/parallel_sort.h>
    ${ARGN})
endfunction ()

set(TREEAMR_VTK_HEADERS
  <vtkCellData.h> <vtkDoubleArray.h> <vtkHyperTreeGrid.h> <vtkInformation.h> <vtkNew.h> <vtkSmartPointer.h>)
