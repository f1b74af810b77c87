// Random hierarchies of blocks become trees in which each place of the domain has the value of the finest block that has
// it; what is no such hierarchy is an error that says which block.
#include "vtkTreeAMRFromOverlappingAMR.h"

#include "Support/GridMakers.h"
#include "Support/Hexahedra.h"
#include "Support/HyperTreeGrids.h"

#include "Geometry/Octant.h"

#include "vtkAMRBox.h"
#include "vtkAMRGaussianPulseSource.h"
#include "vtkAMRInformation.h"
#include "vtkAMRUtilities.h"
#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDataSetAttributes.h"
#include "vtkDoubleArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkIntArray.h"
#include "vtkMatrix3x3.h"
#include "vtkNew.h"
#include "vtkOverlappingAMR.h"
#include "vtkPointData.h"
#include "vtkPointDataToCellData.h"
#include "vtkStringArray.h"
#include "vtkStructuredData.h"
#include "vtkTrivialProducer.h"
#include "vtkUniformGrid.h"
#include "vtkUnsignedCharArray.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <vector>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

using Index = std::array<int, 3>;

/// Cells of a level from `low` on, below `high`.
struct Block
{
  Index low;
  Index high;

  Index size() const { return { high[0] - low[0], high[1] - low[1], high[2] - low[2] }; }
  int cellCount() const { return size()[0] * size()[1] * size()[2]; }
  bool has(const Index& index) const
  {
    bool is = true;
    for (int a = 0; a < 3; ++a)
    {
      is = is && low[a] <= index[a] && index[a] < high[a];
    }
    return is;
  }
  int cell(const Index& index) const
  {
    return index[0] - low[0] + size()[0] * (index[1] - low[1] + size()[1] * (index[2] - low[2]));
  }
};

struct Hierarchy
{
  std::vector<std::vector<Block>> levels;
  std::vector<int> ratios; // of a level to the next
  std::array<double, 3> origin{ -0.7, 1e2, 0.1 };
  std::array<double, 3> spacing{ 0.3, 7., 1. / 3. };

  /// Of a level's cells to the finest ones.
  int scale(std::size_t level) const
  {
    int product = 1;
    for (std::size_t l = level; l + 1 < levels.size(); ++l)
    {
      product *= ratios[l];
    }
    return product;
  }
  std::array<double, 3> widthOf(std::size_t level) const
  {
    std::array<double, 3> width;
    for (int a = 0; a < 3; ++a)
    {
      width[a] = spacing[a] * scale(level) / scale(0);
    }
    return width;
  }
};

/// One block of 4^3, a block of its first octant refined once, 4^3 too.
Hierarchy twoBlocks()
{
  Hierarchy hierarchy;
  hierarchy.levels = { { { { 0, 0, 0 }, { 4, 4, 4 } } }, { { { 0, 0, 0 }, { 4, 4, 4 } } } };
  hierarchy.ratios = { 2 };
  return hierarchy;
}

/// The cells of all blocks are numbered. Those of other levels than in a mask are known, but not there.
vtkSmartPointer<vtkOverlappingAMR> makeAMR(const Hierarchy& hierarchy, unsigned int levels = ~0u)
{
  const auto amr = vtkSmartPointer<vtkOverlappingAMR>::New();
  std::vector<int> counts;
  for (const std::vector<Block>& blocks : hierarchy.levels)
  {
    counts.push_back(static_cast<int>(blocks.size()));
  }
  amr->Initialize(static_cast<int>(counts.size()), counts.data());
  amr->SetOrigin(hierarchy.origin.data());
  amr->SetGridDescription(VTK_XYZ_GRID);
  int first = 0;
  for (unsigned int l = 0; l < hierarchy.levels.size(); ++l)
  {
    const std::array<double, 3> width = hierarchy.widthOf(l);
    amr->SetSpacing(l, width.data());
    if (l < hierarchy.ratios.size())
    {
      amr->SetRefinementRatio(l, hierarchy.ratios[l]);
    }
    for (unsigned int b = 0; b < hierarchy.levels[l].size(); ++b)
    {
      const Block& block = hierarchy.levels[l][b];
      vtkNew<vtkUniformGrid> grid;
      std::array<double, 3> origin = hierarchy.origin;
      if (b % 2 == 0) // the place by the extent, or by the origin
      {
        grid->SetExtent(
          block.low[0], block.high[0], block.low[1], block.high[1], block.low[2], block.high[2]);
      }
      else
      {
        grid->SetExtent(0, block.size()[0], 0, block.size()[1], 0, block.size()[2]);
        for (int a = 0; a < 3; ++a)
        {
          origin[a] += block.low[a] * width[a];
        }
      }
      grid->SetOrigin(origin.data());
      grid->SetSpacing(width.data());
      std::vector<int> numbers(block.cellCount());
      std::iota(numbers.begin(), numbers.end(), first);
      first += block.cellCount();
      addNumbers(grid->GetCellData(), numbers);
      int high[3];
      std::ranges::transform(block.high, high, [](int i) { return i - 1; });
      amr->SetAMRBox(l, b, vtkAMRBox(block.low.data(), high));
      if (levels >> l & 1)
      {
        amr->SetDataSet(l, b, grid);
      }
    }
  }
  return amr;
}

void setGhosts(vtkUniformGrid* grid, const std::vector<std::pair<int, unsigned char>>& flags)
{
  vtkNew<vtkUnsignedCharArray> ghosts;
  ghosts->SetName(vtkDataSetAttributes::GhostArrayName());
  ghosts->SetNumberOfValues(grid->GetNumberOfCells());
  ghosts->FillValue(0);
  for (const auto& [cell, flag] : flags)
  {
    ghosts->SetValue(cell, flag);
  }
  grid->GetCellData()->AddArray(ghosts);
}

MadeGrid convert(vtkDataObject* input)
{
  return makeGridBy<vtkTreeAMRFromOverlappingAMR>(input);
}

std::string errorOf(vtkDataObject* input)
{
  return test::errorOf<vtkTreeAMRFromOverlappingAMR>(input);
}

/// All cells of the finest level around all blocks.
Block domainOf(const Hierarchy& hierarchy)
{
  Block domain{ { 1 << 30, 1 << 30, 1 << 30 }, { -(1 << 30), -(1 << 30), -(1 << 30) } };
  for (std::size_t l = 0; l < hierarchy.levels.size(); ++l)
  {
    for (const Block& block : hierarchy.levels[l])
    {
      for (int a = 0; a < 3; ++a)
      {
        domain.low[a] = std::min(domain.low[a], block.low[a] * hierarchy.scale(l));
        domain.high[a] = std::max(domain.high[a], block.high[a] * hierarchy.scale(l));
      }
    }
  }
  return domain;
}

template <class Visit>
void forEachIndex(const Block& block, const Visit& visit)
{
  Index i;
  for (i[2] = block.low[2]; i[2] < block.high[2]; ++i[2])
  {
    for (i[1] = block.low[1]; i[1] < block.high[1]; ++i[1])
    {
      for (i[0] = block.low[0]; i[0] < block.high[0]; ++i[0])
      {
        visit(i);
      }
    }
  }
}

constexpr int none = -1;

struct Owner
{
  int number = none;
  std::size_t level = 0;
};

/// By cells of the domain: of the first block of the finest level that has it. By painting from the last to the first.
std::vector<Owner> ownersOf(const Hierarchy& hierarchy, const Block& domain)
{
  std::vector<Owner> owners(static_cast<std::size_t>(domain.cellCount()));
  int first = 0;
  for (std::size_t l = 0; l < hierarchy.levels.size(); ++l)
  {
    int next = first;
    std::vector<int> starts;
    for (const Block& block : hierarchy.levels[l])
    {
      starts.push_back(next);
      next += block.cellCount();
    }
    const int scale = hierarchy.scale(l);
    for (std::size_t b = hierarchy.levels[l].size(); b-- > 0;)
    {
      const Block& block = hierarchy.levels[l][b];
      forEachIndex(block, [&](const Index& i) {
        Block cell;
        for (int a = 0; a < 3; ++a)
        {
          cell.low[a] = i[a] * scale;
          cell.high[a] = (i[a] + 1) * scale;
        }
        forEachIndex(cell, [&](const Index& fine) {
          owners[domain.cell(fine)] = { starts[b] + block.cell(i), l };
        });
      });
    }
    first = next;
  }
  return owners;
}

/// Leaves are the owners' cells, each with its values, and parts of those that do not own all of their places. Returns
/// whether there are any of these.
bool expectOwners(
  vtkHyperTreeGrid* grid, const Hierarchy& hierarchy, const std::vector<Owner>& owners, const Block& domain)
{
  std::map<int, int> places; // by owner
  for (const Owner& owner : owners)
  {
    ++places[owner.number];
  }
  vtkDataArray* const numbers = grid->GetCellData()->GetArray("number");
  vtkDataArray* const hashes = grid->GetCellData()->GetArray("hash");
  EXPECT_TRUE(vtkIntArray::SafeDownCast(numbers));
  EXPECT_TRUE(vtkDoubleArray::SafeDownCast(hashes));
  EXPECT_STREQ(hashes->GetComponentName(1), "second");
  std::vector<int> seen(owners.size(), none);
  const std::array<double, 3> fine = hierarchy.widthOf(hierarchy.levels.size() - 1);
  int wrong = 0;
  bool areDivided = false;
  forEachLeaf(grid, [&](const double* bounds, vtkIdType id) {
    const auto number = static_cast<int>(numbers->GetComponent(id, 0));
    wrong += hashes->GetComponent(id, 0) != hashOf(number, 0);
    wrong += hashes->GetComponent(id, 2) != hashOf(number, 2);
    Block leaf;
    for (int a = 0; a < 3; ++a)
    {
      for (int side = 0; side < 2; ++side)
      {
        const double at = (bounds[2 * a + side] - hierarchy.origin[a]) / fine[a];
        const auto plane = static_cast<int>(std::lround(at));
        wrong += std::abs(at - plane) > 1e-6;
        (side == 0 ? leaf.low : leaf.high)[a] = plane;
      }
    }
    forEachIndex(leaf, [&](const Index& i) {
      ASSERT_TRUE(domain.has(i));
      const Owner& owner = owners[domain.cell(i)];
      wrong += seen[domain.cell(i)] != none;
      seen[domain.cell(i)] = number;
      const int scale = hierarchy.scale(owner.level);
      const bool isWhole = places[owner.number] == scale * scale * scale;
      const int width = leaf.size()[0];
      wrong += isWhole ? width != scale : width >= scale;
      areDivided = areDivided || !isWhole;
    });
  });
  EXPECT_EQ(wrong, 0);
  EXPECT_TRUE(std::ranges::equal(seen, owners, {}, {}, &Owner::number));
  return areDivided;
}

/// Returns whether cells are divided.
bool expectTree(const Hierarchy& hierarchy, vtkOverlappingAMR* amr)
{
  const MadeGrid result = convert(amr);
  EXPECT_TRUE(result.errors.empty());
  const Block domain = domainOf(hierarchy);
  const bool areDivided = expectOwners(result.grid, hierarchy, ownersOf(hierarchy, domain), domain);
  EXPECT_EQ(result.warnings.size(), areDivided ? 1u : 0u);
  for (const std::string& warning : result.warnings)
  {
    expectIn(warning, "finer blocks cover cells in part, the first of level ");
  }
  return areDivided;
}

struct RandomHierarchy
{
  std::uint32_t seed = 1;
  Index roots{ 8, 6, 4 };
  std::vector<int> ratios{ 2, 2 };
  int blocks = 3;        // of a level
  bool aligned = true;   // else blocks begin and end anywhere in their level's cells
  bool nested = true;    // else they lie anywhere, beyond the domain too
  bool disjoint = false; // on a level
};

bool intersect(const Block& a, const Block& b)
{
  bool meets = true;
  for (int axis = 0; axis < 3; ++axis)
  {
    meets = meets && a.low[axis] < b.high[axis] && b.low[axis] < a.high[axis];
  }
  return meets;
}

Hierarchy makeHierarchy(const RandomHierarchy& options)
{
  std::mt19937 random(options.seed);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<std::uint32_t>(n)); };
  Hierarchy hierarchy;
  hierarchy.ratios = options.ratios;
  // Two blocks side by side, and a gap when not nested.
  const int cut = 1 + below(options.roots[0] - 2);
  const Index& roots = options.roots;
  hierarchy.levels.push_back(
    { { { 0, 0, 0 }, { cut, roots[1], roots[2] } }, { { cut + (options.nested ? 0 : 1), 0, 0 }, roots } });
  for (const int ratio : options.ratios)
  {
    const std::vector<Block>& parents = hierarchy.levels.back();
    std::vector<Block> blocks;
    for (int tries = 0; tries < 200 && static_cast<int>(blocks.size()) < options.blocks; ++tries)
    {
      const int unit = options.aligned ? ratio : 1;
      Block within = parents[below(static_cast<int>(parents.size()))];
      Block block;
      for (int a = 0; a < 3; ++a)
      {
        const int grown = options.nested ? 0 : 2;
        const int low = (within.low[a] - grown) * ratio / unit;
        const int high = (within.high[a] + grown) * ratio / unit;
        const int size = 1 + below(high - low);
        block.low[a] = (low + below(high - low - size + 1)) * unit;
        block.high[a] = block.low[a] + size * unit;
      }
      if (!options.disjoint ||
        std::ranges::none_of(blocks, [&](const Block& other) { return intersect(block, other); }))
      {
        blocks.push_back(block);
      }
    }
    hierarchy.levels.push_back(blocks);
  }
  return hierarchy;
}

} // namespace

TEST(FromOverlappingAMR, EachPlaceHasTheFinestBlocksValue)
{
  const std::vector<std::vector<int>> ratios{ { 2, 2 }, { 4 }, { 2, 4 }, { 4, 2 }, { 2, 2, 2 }, { 8 } };
  for (std::uint32_t seed = 0; seed < 12; ++seed)
  {
    RandomHierarchy options;
    options.seed = seed;
    options.ratios = ratios[seed % ratios.size()];
    options.disjoint = seed % 2 == 0;
    options.nested = seed % 4 != 3;
    options.roots = seed % 3 == 0 ? Index{ 8, 6, 4 } : seed % 3 == 1 ? Index{ 5, 3, 3 } : Index{ 8, 8, 8 };
    SCOPED_TRACE(seed);
    const Hierarchy hierarchy = makeHierarchy(options);
    const bool areDivided = expectTree(hierarchy, makeAMR(hierarchy));
    EXPECT_TRUE(
      !areDivided || !options.nested); // else blocks of the third level may divide the first one's cells
  }
}

TEST(FromOverlappingAMR, BlankedOrNot)
{
  for (const std::vector<int>& ratios : { std::vector<int>{ 2, 2 }, std::vector<int>{ 4, 2 } })
  {
    RandomHierarchy options;
    options.ratios = ratios;
    options.disjoint = true;
    const Hierarchy hierarchy = makeHierarchy(options);
    const auto amr = makeAMR(hierarchy);
    amr->GenerateParentChildInformation();
    vtkAMRUtilities::BlankCells(amr);
    int refined = 0;
    for (const unsigned int b : { 0u, 1u })
    {
      vtkUniformGrid* const grid = amr->GetDataSet(0, b);
      for (vtkIdType i = 0; i < grid->GetNumberOfCells(); ++i)
      {
        refined += !grid->IsCellVisible(i);
      }
    }
    ASSERT_GT(refined, 0);
    EXPECT_FALSE(expectTree(hierarchy, amr));
  }
}

TEST(FromOverlappingAMR, CellsThatAreCoveredInPartAreDivided)
{
  for (std::uint32_t seed = 0; seed < 8; ++seed)
  {
    RandomHierarchy options;
    options.seed = seed;
    options.ratios = seed % 3 == 0 ? std::vector<int>{ 4, 2 } : std::vector<int>{ 2, 2 };
    options.aligned = false;
    options.nested = seed % 2 == 0;
    options.blocks = 4;
    SCOPED_TRACE(seed);
    const Hierarchy hierarchy = makeHierarchy(options);
    const auto amr = makeAMR(hierarchy);
    EXPECT_TRUE(expectTree(hierarchy, amr));
    if (options.nested)
    {
      // VTK blanks the cells that are covered in part as well.
      amr->GenerateParentChildInformation();
      vtkAMRUtilities::BlankCells(amr);
      EXPECT_TRUE(expectTree(hierarchy, amr));
    }
  }
  // Two halves make a whole.
  Hierarchy halves = twoBlocks();
  halves.levels[1] = { { { 0, 0, 0 }, { 3, 4, 4 } }, { { 3, 0, 0 }, { 6, 4, 4 } } };
  EXPECT_FALSE(expectTree(halves, makeAMR(halves)));
}

TEST(FromOverlappingAMR, LargeBlocks)
{
  // Several chunks of each, of which the work is divided into.
  Hierarchy hierarchy = twoBlocks();
  hierarchy.levels = { { { { 0, 0, 0 }, { 40, 40, 40 } } },
    { { { 10, 10, 2 }, { 50, 50, 62 } }, { { 50, 0, 0 }, { 60, 20, 80 } } } };
  EXPECT_FALSE(expectTree(hierarchy, makeAMR(hierarchy)));
}

TEST(FromOverlappingAMR, RootsAreTheCoarsestCellsOrJoined)
{
  Hierarchy hierarchy;
  hierarchy.levels = { { { { 0, 0, 0 }, { 12, 4, 8 } } } };
  const MadeGrid joined = convert(makeAMR(hierarchy));
  EXPECT_EQ(joined.grid->GetNumberOfNonEmptyTrees(), 3 * 1 * 2);
  EXPECT_FALSE(joined.grid->HasMask());
  double bounds[6];
  joined.grid->GetBounds(bounds);
  for (int a = 0; a < 3; ++a)
  {
    EXPECT_EQ(bounds[2 * a], hierarchy.origin[a]);
    const double width = hierarchy.levels[0][0].size()[a] * hierarchy.spacing[a];
    EXPECT_NEAR(bounds[2 * a + 1], hierarchy.origin[a] + width, 1e-12);
  }
  hierarchy.levels = { { { { 0, 0, 0 }, { 3, 4, 4 } } } };
  EXPECT_EQ(convert(makeAMR(hierarchy)).grid->GetNumberOfNonEmptyTrees(), 3 * 4 * 4);
}

TEST(FromOverlappingAMR, LevelsWithoutBlocks)
{
  RandomHierarchy options;
  options.disjoint = true;
  Hierarchy hierarchy = makeHierarchy(options);
  const std::vector<std::vector<Block>> levels = hierarchy.levels;
  for (std::size_t l = 0; l < 3; ++l)
  {
    hierarchy.levels = levels;
    hierarchy.levels[l].clear();
    const auto amr = makeAMR(hierarchy);
    EXPECT_EQ(expectTree(hierarchy, amr), l == 1);
  }
  // Blocks that are not there, as those of other processes.
  hierarchy.levels = levels;
  const MadeGrid partial = convert(makeAMR(hierarchy, 3u));
  EXPECT_TRUE(partial.errors.empty());
  hierarchy.levels.pop_back();
  hierarchy.ratios.pop_back();
  const Block domain = domainOf(hierarchy);
  expectOwners(partial.grid, hierarchy, ownersOf(hierarchy, domain), domain);

  vtkNew<vtkOverlappingAMR> empty;
  EXPECT_TRUE(convert(empty).errors.empty());
  Hierarchy none;
  none.levels = { {}, {} };
  none.ratios = { 2 };
  const MadeGrid result = convert(makeAMR(none));
  EXPECT_TRUE(result.errors.empty());
  EXPECT_EQ(result.grid->GetNumberOfNonEmptyTrees(), 0);
}

TEST(FromOverlappingAMR, GhostsAreLeftOut)
{
  const Hierarchy hierarchy = twoBlocks();
  const auto amr = makeAMR(hierarchy);
  const Block domain = domainOf(hierarchy);
  std::vector<Owner> owners = ownersOf(hierarchy, domain);
  // Of the coarse block: hidden, and refined where no finer block is. Of the fine one: a hidden cell, which no coarser one
  // takes the place of, and a layer of copies, which do not cover what is below them.
  setGhosts(amr->GetDataSet(0, 0),
    { { 63, vtkDataSetAttributes::HIDDENCELL }, { 62, vtkDataSetAttributes::REFINEDCELL },
      { 0, vtkDataSetAttributes::REFINEDCELL } });
  std::vector<std::pair<int, unsigned char>> flags{ { 0, vtkDataSetAttributes::HIDDENCELL } };
  for (int i = 0; i < 16; ++i)
  {
    flags.emplace_back(3 + 4 * i, vtkDataSetAttributes::DUPLICATECELL);
  }
  setGhosts(amr->GetDataSet(1, 0), flags);
  const Block coarse = hierarchy.levels[0][0];
  const Block fine = hierarchy.levels[1][0];
  forEachIndex(domain, [&](const Index& i) {
    Owner& owner = owners[domain.cell(i)];
    const int number = coarse.cell({ i[0] / 2, i[1] / 2, i[2] / 2 });
    if (number >= 62 || i == Index{ 0, 0, 0 })
    {
      owner.number = none;
    }
    else if (i[0] == 3 && fine.has(i))
    {
      owner = { number, 0 };
    }
  });
  const MadeGrid result = convert(amr);
  ASSERT_TRUE(result.errors.empty()) << result.errors[0];
  EXPECT_TRUE(expectOwners(result.grid, hierarchy, owners, domain));
  EXPECT_FALSE(result.grid->GetCellData()->HasArray(vtkDataSetAttributes::GhostArrayName()));

  // Points that are blanked blank their cells, as VTK has it.
  const auto blanked = makeAMR(hierarchy);
  vtkUniformGrid* const block = blanked->GetDataSet(0, 0);
  block->BlankPoint(4, 4, 4);
  ASSERT_FALSE(block->IsCellVisible(63));
  ASSERT_TRUE(block->IsCellVisible(62));
  EXPECT_EQ(convert(blanked).grid->GetNumberOfLeaves(), 64 - 8 + 64);
  int leaves = 0;
  forEachLeaf(convert(blanked).grid, [&](const double*, vtkIdType) { ++leaves; });
  EXPECT_EQ(leaves, 64 - 8 + 64 - 1);

  // None but ghosts.
  for (const unsigned int level : { 0u, 1u })
  {
    vtkUniformGrid* const all = amr->GetDataSet(level, 0);
    all->GetCellGhostArray()->FillComponent(0, vtkDataSetAttributes::DUPLICATECELL);
  }
  EXPECT_TRUE(convert(amr).errors.empty());
}

TEST(FromOverlappingAMR, Arrays)
{
  const Hierarchy hierarchy = twoBlocks();
  const auto amr = makeAMR(hierarchy);
  std::array<vtkSmartPointer<vtkDataArray>, 2> means;
  for (const unsigned int level : { 0u, 1u })
  {
    vtkUniformGrid* const grid = amr->GetDataSet(level, 0);
    vtkNew<vtkStringArray> strings;
    strings->SetName("string");
    for (vtkIdType i = 0; i < grid->GetNumberOfCells(); ++i)
    {
      strings->InsertNextValue(std::to_string(i + 100 * level));
    }
    grid->GetCellData()->AddArray(strings);
    grid->GetCellData()->SetActiveScalars("hash");
    vtkNew<vtkDoubleArray> points;
    points->SetName("points");
    for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i)
    {
      points->InsertNextValue(std::sin(7. * static_cast<double>(i) + level));
    }
    grid->GetPointData()->AddArray(points);
    vtkNew<vtkPointDataToCellData> averages;
    averages->SetInputData(grid);
    averages->Update();
    means[level] = averages->GetOutput()->GetCellData()->GetArray("points");
  }
  vtkNew<vtkDoubleArray> other;
  other->SetName("other");
  other->SetNumberOfValues(64);
  amr->GetDataSet(1, 0)->GetCellData()->AddArray(other);

  vtkNew<vtkTreeAMRFromOverlappingAMR> filter;
  const MessageCatcher warnings(filter, vtkCommand::WarningEvent);
  filter->SetInputDataObject(amr);
  filter->Update();
  filter->Modified();
  filter->Update();
  ASSERT_EQ(warnings.messages().size(), 2u);
  expectIn(warnings.messages()[0], "arrays of points are averaged to the cells: points.");
  expectIn(warnings.messages()[1], "left out: cell array 'other' is not in level 0, block 0.");

  auto* const grid = vtkHyperTreeGrid::SafeDownCast(filter->GetOutputDataObject(0));
  vtkCellData* const data = grid->GetCellData();
  EXPECT_STREQ(data->GetScalars()->GetName(), "hash");
  EXPECT_FALSE(data->HasArray("other"));
  int leaves = 0;
  forEachLeaf(grid, [&](const double*, vtkIdType id) {
    const auto number = static_cast<vtkIdType>(data->GetArray("number")->GetComponent(id, 0));
    EXPECT_EQ(data->GetAbstractArray("string")->GetVariantValue(id).ToString(),
      std::to_string(number % 64 + 100 * (number / 64)));
    EXPECT_EQ(
      data->GetArray("points")->GetComponent(id, 0), means[number / 64]->GetComponent(number % 64, 0));
    ++leaves;
  });
  EXPECT_EQ(leaves, 64 - 8 + 64);
}

TEST(FromOverlappingAMR, VTKsOwnSource)
{
  for (const int ratio : { 2, 4, 3 })
  {
    vtkNew<vtkAMRGaussianPulseSource> source;
    source->SetDimension(3);
    source->SetRefinementRatio(ratio);
    source->Update();
    vtkDataObject* const amr = source->GetOutputDataObject(0);
    if (ratio == 3)
    {
      expectIn(errorOf(amr),
        "level 1, block 0 has cells of (0.1666666667, 0.1666666667, 0.1666666667), level 0, block 0 of (0.5, "
        "0.5, "
        "0.5), a refinement ratio of (3, 3, 3); allowed are 2, 4, 8 ..., alike along all axes");
      continue;
    }
    const MadeGrid result = convert(amr);
    ASSERT_TRUE(result.errors.empty()) << result.errors[0];
    // The source's own formula at the leaves' centres.
    vtkDataArray* const pulse = result.grid->GetCellData()->GetArray("Gaussian-Pulse");
    double volume = 0.;
    forEachLeaf(result.grid, [&](const double* bounds, vtkIdType id) {
      double exponent = 0.;
      for (int a = 0; a < 3; ++a)
      {
        const double x = (bounds[2 * a] + bounds[2 * a + 1]) / 2. - source->GetPulseOrigin()[a];
        exponent += x * x / (source->GetPulseWidth()[a] * source->GetPulseWidth()[a]);
      }
      EXPECT_NEAR(pulse->GetComponent(id, 0), source->GetPulseAmplitude() * std::exp(-exponent), 1e-12);
      volume += (bounds[1] - bounds[0]) * (bounds[3] - bounds[2]) * (bounds[5] - bounds[4]);
    });
    double whole[6];
    result.grid->GetBounds(whole);
    EXPECT_NEAR(volume, (whole[1] - whole[0]) * (whole[3] - whole[2]) * (whole[5] - whole[4]), 1e-12);
  }
  vtkNew<vtkAMRGaussianPulseSource> flat;
  flat->SetDimension(2);
  flat->Update();
  expectIn(errorOf(flat->GetOutputDataObject(0)),
    "level 0, block 0 has 6 x 6 x 1 points, data of 2 dimensions; allowed is data of three");
}

TEST(FromOverlappingAMR, BlocksThatFitNotAreNamed)
{
  const Hierarchy hierarchy = twoBlocks();
  const auto withBlock = [&](std::array<double, 3> widths, std::array<double, 3> shift) {
    const auto amr = makeAMR(hierarchy);
    vtkUniformGrid* const fine = amr->GetDataSet(1, 0);
    const std::array<double, 3> right = hierarchy.widthOf(1);
    double origin[3];
    double spacing[3];
    for (int a = 0; a < 3; ++a)
    {
      spacing[a] = widths[a] * right[a];
      origin[a] = hierarchy.origin[a] + shift[a] * right[a];
    }
    fine->SetOrigin(origin);
    fine->SetSpacing(spacing);
    return amr;
  };
  EXPECT_TRUE(convert(withBlock({ 1., 1., 1. }, { 1e-6, 0., 0. })).errors.empty());
  expectIn(errorOf(withBlock({ 1., 1., 1. }, { 0.5, 0., 0. })),
    "level 1, block 0, whose cells of (0.15, 3.5, 0.1666666667) begin at (-0.625, 100, 0.1), fits not the "
    "lattice of the coarsest ones, which are (0.3, 7, 0.3333333333) wide like that from ");
  expectIn(errorOf(withBlock({ 1., 1., 2. }, { 0., 0., 0. })), "a refinement ratio of (2, 2, 1); allowed");
  expectIn(errorOf(withBlock({ 2., 2., 2. }, { 0., 0., 0. })), "a refinement ratio of (1, 1, 1); allowed");
  expectIn(errorOf(withBlock({ 0., 1., 1. }, { 0., 0., 0. })),
    "level 1, block 0 has cells of (0, 3.5, 0.1666666667)");
  expectIn(errorOf(withBlock({ -1., 1., 1. }, { 0., 0., 0. })), "level 1, block 0 has cells of (-0.15, ");
  expectIn(errorOf(withBlock({ 1., 1., 1. }, { 0., std::nan(""), 0. })), "from (-0.7, nan, 0.1) on");
  expectIn(errorOf(withBlock({ 1., 1., 1. }, { 0., 1e30, 0. })), "tell the cells' planes apart");
  expectIn(errorOf(withBlock({ 1., 1., 1. }, { 0., 1e8, 0. })), "allowed are 1048576");

  Hierarchy unlike = hierarchy;
  unlike.levels[1].push_back({ { 4, 4, 4 }, { 8, 8, 8 } });
  const auto two = makeAMR(unlike);
  two->GetDataSet(1, 1)->SetSpacing(hierarchy.spacing.data());
  expectIn(errorOf(two),
    "level 1, block 1 has cells of (0.3, 7, 0.3333333333), level 1, block 0 of (0.15, 3.5, 0.1666666667); "
    "allowed are cells of one size on a level");

  const auto turned = makeAMR(hierarchy);
  turned->GetDataSet(1, 0)->GetDirectionMatrix()->SetElement(0, 0, -1.);
  expectIn(errorOf(turned), "level 1, block 0 has a direction matrix");

  const auto shortArray = makeAMR(hierarchy);
  shortArray->GetDataSet(1, 0)->GetCellData()->GetArray("number")->SetNumberOfTuples(63);
  expectIn(errorOf(shortArray), "level 1, block 0: cell array 'number' has 63 tuples, allowed are 64");
  const auto shortGhosts = makeAMR(hierarchy);
  setGhosts(shortGhosts->GetDataSet(0, 0), {});
  shortGhosts->GetDataSet(0, 0)->GetCellGhostArray()->SetNumberOfTuples(3);
  expectIn(errorOf(shortGhosts), "level 0, block 0: vtkGhostType has 3 tuples, allowed are 64");
}

// Of several pieces in one process.
TEST(FromOverlappingAMR, OtherPiecesAreEmpty)
{
  vtkNew<vtkTrivialProducer> source; // gives all to whoever asks
  const auto amr = makeAMR(twoBlocks());
  source->SetOutput(amr);
  vtkNew<vtkTreeAMRFromOverlappingAMR> filter;
  filter->SetInputConnection(source->GetOutputPort());
  filter->UpdatePiece(1, 2, 0);
  EXPECT_EQ(vtkHyperTreeGrid::SafeDownCast(filter->GetOutputDataObject(0))->GetNumberOfNonEmptyTrees(), 0);
  filter->UpdatePiece(0, 2, 0);
  EXPECT_EQ(vtkHyperTreeGrid::SafeDownCast(filter->GetOutputDataObject(0))->GetNumberOfLeaves(), 64 - 8 + 64);
}
