// How much memory what is kept between frames may take.
#pragma once

#include <cstddef>

namespace treeamr
{

/// Bytes that suit most scenes: of vertex values for volumes, and of those for isosurfaces.
inline constexpr std::size_t defaultKeptBytes = std::size_t(512) << 20;

} // namespace treeamr
