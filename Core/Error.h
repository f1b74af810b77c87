// The exception of the VTK-free core.
#pragma once

#include <stdexcept>
#include <string>

namespace treeamr
{

/// Names the object, the value found and what is allowed. VTK entry points catch it and report it.
class Error : public std::runtime_error
{
public:
  /// Bytes of a file that are no UTF-8 are shown as "?": Python takes no other text, and would lose all of it.
  explicit Error(const std::string& text);
};

} // namespace treeamr
