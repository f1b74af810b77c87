// Speed and memory of reading forests, beside libp4est's own loading.
#pragma once

#include "Report.h"

#include <string>
#include <vector>

namespace treeamr::bench
{

/// Of a forest with one double per quadrant. Memory is what is resident beyond the grid at most. Throws Error when it cannot
/// be read.
std::vector<Figure> readingFigures(const std::string& path);

} // namespace treeamr::bench
