#pragma once

#include <string>

namespace treeamr::report
{

struct Options
{
  std::string folder; // of the forests and their converged pictures
  bool brief = false; // the first data set alone, in a small picture, with few settings
};

} // namespace treeamr::report
