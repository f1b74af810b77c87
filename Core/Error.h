// The exception of the VTK-free core.
#pragma once

#include <stdexcept>

namespace treeamr
{

/// Names the object, the value found and what is allowed. VTK entry points catch it and report it.
class Error : public std::runtime_error
{
public:
  using std::runtime_error::runtime_error;
};

} // namespace treeamr
