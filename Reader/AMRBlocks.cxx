#include "AMRBlocks.h"

#include "Error.h"

#include "vtkDataSetAttributes.h"
#include "vtkMatrix3x3.h"
#include "vtkOverlappingAMR.h"
#include "vtkUniformGrid.h"
#include "vtkVersionMacros.h"
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 6, 0)
#include "vtkUniformGridAMRIterator.h"
#else
#include "vtkUniformGridAMRDataIterator.h"
#endif
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

namespace treeamr
{

namespace
{

/// What vtkOverlappingAMR::NewIterator() makes.
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 6, 0)
using BlockIterator = vtkUniformGridAMRIterator;
#else
using BlockIterator = vtkUniformGridAMRDataIterator;
#endif

/// Relative, to which widths are compared: coordinates of six digits and a fine block a few cells wide.
constexpr double alike = 1e-3;

bool areAlike(double a, double b) noexcept
{
  return std::abs(a - b) <= alike * b;
}

std::array<double, 3> ratios(const AMRBlock& coarse, const AMRBlock& fine) noexcept
{
  std::array<double, 3> ratio;
  for (int a = 0; a < 3; ++a)
  {
    ratio[a] = coarse.width()[a] / fine.width()[a];
  }
  return ratio;
}

void checkWidths(const std::vector<AMRBlock>& blocks)
{
  for (std::size_t b = 1; b < blocks.size(); ++b)
  {
    const AMRBlock& before = blocks[b - 1];
    const AMRBlock& block = blocks[b];
    const std::array<double, 3> ratio = ratios(before, block);
    const bool isSameLevel = block.level() == before.level();
    const double wanted = isSameLevel ? 1. : std::max(2., std::exp2(std::round(std::log2(ratio[0]))));
    if (std::ranges::all_of(ratio, [&](double r) { return areAlike(r, wanted); }))
    {
      continue;
    }
    std::ostringstream text;
    text.precision(6);
    text << block.name() << " has cells of " << textOf(block.width()) << ", " << before.name() << " of "
         << textOf(before.width());
    if (isSameLevel)
    {
      text << "; allowed are cells of one size on a level";
    }
    else
    {
      text << ", a refinement ratio of (" << ratio[0] << ", " << ratio[1] << ", " << ratio[2]
           << "); allowed are 2, 4, 8 ..., alike along all axes";
    }
    throw Error(text.str());
  }
}

} // namespace

AMRBlock::AMRBlock(vtkImageData* data, int level, std::string name)
  : data_(data)
  , level_(level)
  , name_(std::move(name))
{
  std::array<int, 3> points;
  data->GetDimensions(points.data());
  if (std::ranges::any_of(points, [](int n) { return n < 2; }))
  {
    throw Error(name_ + " has " + std::to_string(points[0]) + " x " + std::to_string(points[1]) + " x " +
      std::to_string(points[2]) + " points, data of " + std::to_string(data->GetDataDimension()) +
      " dimensions; allowed is data of three");
  }
  if (!data->GetDirectionMatrix()->IsIdentity())
  {
    throw Error(name_ + " has a direction matrix that turns or reflects it; allowed are axes as they are");
  }
  const int* const extent = data->GetExtent();
  for (int a = 0; a < 3; ++a)
  {
    size_[a] = points[a] - 1;
    width_[a] = data->GetSpacing()[a];
    low_[a] = data->GetOrigin()[a] + extent[2 * a] * width_[a];
  }
  const AxisBox first = this->boxOf({ 0, 0, 0 });
  const AxisBox last = this->boxOf({ size_[0] - 1, size_[1] - 1, size_[2] - 1 });
  for (int a = 0; a < 3; ++a)
  {
    if (!(width_[a] > 0.) || !std::isfinite(first.low[a]) || !std::isfinite(last.high[a]) ||
      !(first.low[a] < first.high[a]) || !(last.low[a] < last.high[a]))
    {
      throw Error(name_ + " has cells of " + textOf(width_) + " from " + textOf(low_) +
        " on; allowed are widths above 0 and finite coordinates that tell the cells' planes apart");
    }
  }
  ghosts_ = cellGhosts({ data, name_ });
  if (vtkUnsignedCharArray* const ghosts = data->GetPointGhostArray();
      ghosts && ghosts->GetNumberOfTuples() >= data->GetNumberOfPoints())
  {
    pointGhosts_ = ghosts->GetPointer(0);
  }
}

AMRBlock::~AMRBlock() = default;
AMRBlock::AMRBlock(AMRBlock&&) noexcept = default;

AxisBox AMRBlock::boxOf(const CellIndex& index) const noexcept
{
  AxisBox box;
  for (int a = 0; a < 3; ++a)
  {
    box.low[a] = low_[a] + static_cast<double>(index[a]) * width_[a];
    box.high[a] = low_[a] + static_cast<double>(index[a] + 1) * width_[a];
  }
  return box;
}

std::array<vtkIdType, 8> AMRBlock::points(vtkIdType cell) const noexcept
{
  const vtkIdType row = cell / size_[0];
  const vtkIdType perRow = size_[0] + 1;
  const vtkIdType perLayer = perRow * (size_[1] + 1);
  const vtkIdType first = cell % size_[0] + perRow * (row % size_[1]) + perLayer * (row / size_[1]);
  return { first, first + 1, first + perRow, first + perRow + 1, first + perLayer, first + perLayer + 1,
    first + perLayer + perRow, first + perLayer + perRow + 1 };
}

bool AMRBlock::isLeftOut(vtkIdType cell) const noexcept
{
  constexpr unsigned char flags = vtkDataSetAttributes::DUPLICATECELL | vtkDataSetAttributes::HIDDENCELL;
  return (ghosts_ && (ghosts_[cell] & flags) != 0) ||
    (pointGhosts_ && std::ranges::any_of(this->points(cell), [&](vtkIdType point) {
      return (pointGhosts_[point] & vtkDataSetAttributes::HIDDENPOINT) != 0;
    }));
}

bool AMRBlock::isRefined(vtkIdType cell) const noexcept
{
  return ghosts_ && (ghosts_[cell] & vtkDataSetAttributes::REFINEDCELL) != 0;
}

AMRBlock::Range AMRBlock::ownCells() const
{
  if (!ghosts_)
  {
    return { {}, size_ };
  }
  Range own{ size_, {} };
  CellIndex at;
  for (at[2] = 0; at[2] < size_[2]; ++at[2])
  {
    for (at[1] = 0; at[1] < size_[1]; ++at[1])
    {
      for (at[0] = 0; at[0] < size_[0]; ++at[0])
      {
        if ((ghosts_[this->cell(at)] & vtkDataSetAttributes::DUPLICATECELL) == 0)
        {
          for (int a = 0; a < 3; ++a)
          {
            own.low[a] = std::min(own.low[a], at[a]);
            own.high[a] = std::max(own.high[a], at[a] + 1);
          }
        }
      }
    }
  }
  return own;
}

std::vector<AMRBlock> blocksOf(vtkOverlappingAMR* input)
{
  std::vector<AMRBlock> blocks;
  const auto iterator = vtk::TakeSmartPointer(BlockIterator::SafeDownCast(input->NewIterator()));
  for (iterator->InitTraversal(); !iterator->IsDoneWithTraversal(); iterator->GoToNextItem())
  {
    const std::string name = "level " + std::to_string(iterator->GetCurrentLevel()) + ", block " +
      std::to_string(iterator->GetCurrentIndex());
    vtkDataObject* const object = iterator->GetCurrentDataObject();
    auto* const data = vtkImageData::SafeDownCast(object);
    if (object && !data)
    {
      throw Error(name + " is a " + object->GetClassName() + ", allowed is vtkUniformGrid");
    }
    if (data && data->GetNumberOfCells() > 0)
    {
      blocks.emplace_back(data, static_cast<int>(iterator->GetCurrentLevel()), name);
    }
  }
  checkWidths(blocks);
  return blocks;
}

BlockArrays arraysOf(const std::vector<AMRBlock>& blocks)
{
  std::vector<NamedDataSet> sets;
  for (const AMRBlock& block : blocks)
  {
    sets.push_back({ block.data(), block.name() });
  }
  return arraysOf(std::move(sets),
    { [&blocks](const CellNumber& number) { return blocks[number.block()].points(number.cell()); } });
}

} // namespace treeamr
