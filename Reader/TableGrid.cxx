#include "TableGrid.h"

#include "Error.h"
#include "GridOfCells.h"
#include "HyperTreeGridBuilder.h"

#include "vtkDataArray.h"
#include "vtkDataSetAttributes.h"
#include "vtkTable.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

namespace treeamr
{

namespace
{

constexpr std::array<const char*, 4> roles{ "levels", "indices along x", "indices along y",
  "indices along z" };
constexpr int maxLevel = HyperTreeGridBuilder::maxLevel;
constexpr double maxRoots = BoxLattice::maxRoots;

std::string numberText(double value)
{
  std::string text(32, '\0');
  text.resize(static_cast<std::size_t>(std::snprintf(text.data(), text.size(), "%.10g", value)));
  return text;
}

std::string rowText(const TableBlock& block, vtkIdType row)
{
  return (block.name.empty() ? "" : block.name + ", ") + "row " + std::to_string(row);
}

std::string describe(const TableBlock& block, vtkIdType row)
{
  std::string text =
    rowText(block, row) + ", level " + numberText(block.places[0]->GetComponent(row, 0)) + " at (";
  for (int a = 0; a < 3; ++a)
  {
    text += (a == 0 ? "" : ", ") + numberText(block.places[a + 1]->GetComponent(row, 0));
  }
  return text + ")";
}

/// Nothing for numbers that are none of a cell. roots: the most along each axis.
std::optional<CellId> cellOf(const TableBlock& block, vtkIdType row, const std::array<double, 3>& roots)
{
  const double level = block.places[0]->GetComponent(row, 0);
  if (!(level >= 0. && level <= maxLevel && level == std::floor(level)))
  {
    return std::nullopt;
  }
  CellId cell{ {}, static_cast<int>(level) };
  for (int a = 0; a < 3; ++a)
  {
    const double index = block.places[a + 1]->GetComponent(row, 0);
    if (!(index >= 0. && index < std::ldexp(roots[a], cell.level) && index == std::floor(index)))
    {
      return std::nullopt;
    }
    cell.index[a] = static_cast<Coord>(index);
  }
  return cell;
}

/// What all cells need.
struct Extent
{
  std::array<int, 3> roots{ 1, 1, 1 };
  int deepest = 0;

  void add(const CellId& cell) noexcept
  {
    deepest = std::max(deepest, cell.level);
    for (int a = 0; a < 3; ++a)
    {
      roots[a] = std::max(roots[a], static_cast<int>(cell.index[a] >> cell.level) + 1);
    }
  }
  void add(const Extent& other) noexcept
  {
    deepest = std::max(deepest, other.deepest);
    for (int a = 0; a < 3; ++a)
    {
      roots[a] = std::max(roots[a], other.roots[a]);
    }
  }
};

/// Checks all rows.
Extent measure(const std::vector<TableBlock>& blocks, const std::array<int, 3>& roots)
{
  std::array<double, 3> most;
  for (int a = 0; a < 3; ++a)
  {
    most[a] = roots[a] > 0 ? roots[a] : maxRoots;
  }
  Extent all;
  for (const TableBlock& block : blocks)
  {
    const Parts parts(static_cast<std::size_t>(block.rows));
    std::vector<Extent> extents(parts.size());
    std::vector<vtkIdType> wrong(parts.size(), -1);
    parts.forEach([&](std::size_t p) {
      for (std::size_t row = parts.begin(p); row < parts.end(p); ++row)
      {
        const auto cell = cellOf(block, static_cast<vtkIdType>(row), most);
        if (!cell)
        {
          wrong[p] = static_cast<vtkIdType>(row);
          return;
        }
        extents[p].add(*cell);
      }
    });
    if (const auto first = std::ranges::find_if(wrong, [](vtkIdType row) { return row >= 0; });
        first != wrong.end())
    {
      throw Error(describe(block, *first) + "; allowed are whole numbers, levels from 0 to " +
        std::to_string(maxLevel) + " and indices from 0 on, below 2^level times " + numberText(most[0]) +
        ", " + numberText(most[1]) + " and " + numberText(most[2]) + " roots");
    }
    for (const Extent& extent : extents)
    {
      all.add(extent);
    }
  }
  for (int a = 0; a < 3; ++a)
  {
    all.roots[a] = roots[a] > 0 ? roots[a] : all.roots[a];
  }
  return all;
}

std::array<std::vector<double>, 3> planesOf(const TableLattice& lattice, const std::array<int, 3>& roots)
{
  std::array<std::vector<double>, 3> planes;
  for (int a = 0; a < 3; ++a)
  {
    for (int i = 0; i <= roots[a]; ++i)
    {
      planes[a].push_back(lattice.origin[a] + i * lattice.spacing[a]);
    }
  }
  return planes;
}

std::string columnsOf(vtkDataSetAttributes& columns)
{
  std::string text;
  for (int i = 0; i < columns.GetNumberOfArrays(); ++i)
  {
    vtkAbstractArray* const column = columns.GetAbstractArray(i);
    text += (text.empty() ? "'" : ", '") + std::string(column->GetName() ? column->GetName() : "") + "'" +
      (vtkDataArray::SafeDownCast(column) ? "" : " of text");
  }
  return text.empty() ? "none" : text;
}

} // namespace

TableBlock::TableBlock(vtkTable* table, const std::array<std::string, 4>& names, std::string tableName)
  : others(vtkSmartPointer<vtkCellData>::New())
  , rows(table->GetNumberOfRows())
  , name(std::move(tableName))
{
  vtkDataSetAttributes* const columns = table->GetRowData();
  const std::string prefix = name.empty() ? "" : name + ": ";
  for (std::size_t c = 0; c < names.size(); ++c)
  {
    places[c] = columns->GetArray(names[c].c_str());
    if (!places[c] || places[c]->GetNumberOfComponents() != 1)
    {
      throw Error(prefix + "no column '" + names[c] + "' of one number a row, for the cells' " + roles[c] +
        "; there are " + columnsOf(*columns));
    }
  }
  for (int i = 0; i < columns->GetNumberOfArrays(); ++i)
  {
    vtkAbstractArray* const column = columns->GetAbstractArray(i);
    if (std::ranges::find(places, column) != places.end())
    {
      continue;
    }
    vtkDataArray* const numbers = vtkDataArray::SafeDownCast(column);
    if (numbers && numbers->GetName())
    {
      others->AddArray(numbers);
    }
    else
    {
      leftOut.push_back(prefix +
        (column->GetName() ? "column '" + std::string(column->GetName()) + "' has no numbers"
                           : "a column has no name"));
    }
  }
  if (others->GetNumberOfArrays() == 0)
  {
    others->AddArray(places[0]);
  }
}

void makeGrid(const std::vector<TableBlock>& blocks, const TableLattice& lattice, const BlockArrays& arrays,
  vtkHyperTreeGrid* grid)
{
  std::size_t rows = 0;
  for (const TableBlock& block : blocks)
  {
    rows += static_cast<std::size_t>(block.rows);
  }
  if (rows == 0)
  {
    return;
  }
  const Extent extent = measure(blocks, lattice.roots);
  const auto planes = planesOf(lattice, extent.roots);
  const std::array<double, 3> roots{ double(extent.roots[0]), double(extent.roots[1]),
    double(extent.roots[2]) };
  const int padding = RootGrid(planes).paddingDepth();
  withKeys(padding + extent.deepest, [&]<class Keys>() {
    SortedCells<Keys, std::uint64_t> cells(padding, extent.deepest, rows);
    std::size_t before = 0;
    for (std::size_t b = 0; b < blocks.size(); ++b)
    {
      const Parts parts(static_cast<std::size_t>(blocks[b].rows));
      parts.forEach([&](std::size_t p) {
        for (std::size_t row = parts.begin(p); row < parts.end(p); ++row)
        {
          const auto number = static_cast<vtkIdType>(row);
          cells.set(before + row, *cellOf(blocks[b], number, roots), CellNumber(b, number).number());
        }
      });
      before += static_cast<std::size_t>(blocks[b].rows);
    }
    cells.sort();
    keepFirstOfDuplicates(
      cells, [&](const CellNumber& first, const CellNumber& second, const CellId& /*place*/) {
        throw Error("cells overlap: " + describe(blocks[first.block()], first.cell()) + ", and " +
          describe(blocks[second.block()], second.cell()));
      });
    buildGrid(cells, planes, arrays, grid);
  });
}

} // namespace treeamr
