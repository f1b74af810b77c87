// Which of several data sets' cells one is. Private to the module.
#pragma once

#include "vtkType.h"

#include <cstddef>
#include <cstdint>

namespace treeamr
{

/// Of a block and in it; in the order of both.
class CellNumber
{
public:
  CellNumber(std::size_t block, vtkIdType cell) noexcept
    : number_(std::uint64_t(block) << cellBits | static_cast<std::uint64_t>(cell))
  {
  }
  explicit CellNumber(std::uint64_t number) noexcept
    : number_(number)
  {
  }
  std::uint64_t number() const noexcept { return number_; }
  std::size_t block() const noexcept { return static_cast<std::size_t>(number_ >> cellBits); }
  vtkIdType cell() const noexcept
  {
    return static_cast<vtkIdType>(number_ & ((std::uint64_t(1) << cellBits) - 1));
  }

private:
  static constexpr int cellBits = 40;
  std::uint64_t number_;
};

} // namespace treeamr
