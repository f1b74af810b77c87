// Cells of many processes, spread in any way: afterwards each has those of its box, and the field there is that of all.
#include "Support/FieldVertices.h"
#include "Support/HyperTreeGrids.h"
#include "Support/ThreadProcesses.h"

#include "CornerArrays.h"
#include "GridExchange.h"
#include "GridPartition.h"
#include "HyperTreeGridConverter.h"

#include "vtkBitArray.h"
#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDataSetAttributes.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkFloatArray.h"
#include "vtkHyperTree.h"
#include "vtkHyperTreeGrid.h"
#include "vtkIdTypeArray.h"
#include "vtkIntArray.h"
#include "vtkLongArray.h"
#include "vtkNew.h"
#include "vtkShortArray.h"
#include "vtkSignedCharArray.h"
#include "vtkStringArray.h"
#include "vtkTreeAMRRedistributeGrid.h"
#include "vtkUnsignedCharArray.h"
#include "vtkUnsignedIntArray.h"
#include "vtkUnsignedLongLongArray.h"
#include "vtkUnsignedShortArray.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdlib>
#include <functional>
#include <limits>
#include <map>
#include <new>
#include <numeric>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

thread_local long untilFailure = 0; // large blocks of this thread; the one that makes it 0 fails
thread_local bool hasFailed = false;

} // namespace

// Inlined, they would look to the compiler like operators that do not belong together.
[[gnu::noinline]] void* operator new(std::size_t size)
{
  constexpr std::size_t large = 4096;
  if (size >= large && untilFailure > 0 && --untilFailure == 0)
  {
    hasFailed = true;
    throw std::bad_alloc();
  }
  if (void* const block = std::malloc(std::max<std::size_t>(size, 1)))
  {
    return block;
  }
  throw std::bad_alloc();
}

[[gnu::noinline]] void operator delete(void* block) noexcept
{
  std::free(block);
}

void operator delete(void* block, std::size_t /*size*/) noexcept
{
  operator delete(block);
}

namespace
{

using Grid = vtkSmartPointer<vtkHyperTreeGrid>;
using Place = std::array<double, 6>; // xmin, xmax, ymin ...

Place placeOf(const double* bounds)
{
  Place place;
  for (int a = 0; a < 3; ++a)
  {
    place[2 * a] = std::min(bounds[2 * a], bounds[2 * a + 1]) + 0.; // no -0
    place[2 * a + 1] = std::max(bounds[2 * a], bounds[2 * a + 1]) + 0.;
  }
  return place;
}

/// Calls visit(place, index) for the leaves that count, also below the depth limit.
void forEachCounted(vtkHyperTreeGrid* grid, const std::function<void(const Place&, vtkIdType)>& visit)
{
  const auto all = vtk::TakeSmartPointer(grid->NewInstance());
  all->ShallowCopy(grid);
  all->SetDepthLimiter(std::numeric_limits<unsigned int>::max());
  vtkUnsignedCharArray* const ghosts = grid->GetGhostCells();
  forEachLeaf(all, [&](const double* bounds, vtkIdType index) {
    if (!ghosts ||
      (ghosts->GetValue(index) & (vtkDataSetAttributes::DUPLICATECELL | vtkDataSetAttributes::HIDDENCELL)) ==
        0)
    {
      visit(placeOf(bounds), index);
    }
  });
}

/// The bytes of all arrays' tuples by place; values at corners in the order of increasing coordinates.
std::map<Place, std::string> countedCells(vtkHyperTreeGrid* grid, int mirrored = 0)
{
  std::map<Place, std::string> cells;
  forEachCounted(grid, [&](const Place& place, vtkIdType index) {
    std::string bytes;
    for (int i = 0; i < grid->GetCellData()->GetNumberOfArrays(); ++i)
    {
      vtkDataArray* const array = grid->GetCellData()->GetArray(i);
      const std::string name = array->GetName();
      if (name == vtkDataSetAttributes::GhostArrayName())
      {
        continue;
      }
      bytes += name;
      const int size = array->GetDataTypeSize();
      for (int c = 0; c < array->GetNumberOfComponents(); ++c)
      {
        const int component = isAtCorners(*array) ? c ^ mirrored : c;
        bytes.append(
          static_cast<const char*>(array->GetVoidPointer(index * array->GetNumberOfComponents() + component)),
          static_cast<std::size_t>(size));
      }
    }
    EXPECT_TRUE(cells.emplace(place, bytes).second);
  });
  return cells;
}

/// Of a place, the same in all copies.
std::size_t hashOf(const Place& place)
{
  std::uint64_t hash = 17;
  for (const double bound : place)
  {
    hash = (hash ^ std::bit_cast<std::uint64_t>(bound)) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 31;
  }
  return hash;
}

enum class Others
{
  Masked,
  Ghosts
};

/// A copy that counts the leaves of isKept(place).
template <class IsKept>
Grid pieceOf(vtkHyperTreeGrid* grid, const IsKept& isKept, Others others = Others::Masked)
{
  const auto piece = vtk::TakeSmartPointer(grid->NewInstance());
  piece->DeepCopy(grid);
  const vtkIdType count = countVertices(grid);
  vtkNew<vtkBitArray> mask;
  vtkNew<vtkUnsignedCharArray> ghosts;
  ghosts->SetName(vtkDataSetAttributes::GhostArrayName());
  for (vtkIdType i = 0; i < count; ++i)
  {
    mask->InsertNextValue(
      grid->GetMask() && grid->GetMask()->GetNumberOfTuples() > i && grid->GetMask()->GetValue(i));
    ghosts->InsertNextValue(0);
  }
  forEachCounted(grid, [&](const Place& place, vtkIdType index) {
    if (!isKept(place))
    {
      others == Others::Masked ? mask->SetValue(index, 1)
                               : ghosts->SetValue(index, vtkDataSetAttributes::DUPLICATECELL);
    }
  });
  piece->SetMask(mask);
  if (others == Others::Ghosts)
  {
    piece->GetCellData()->AddArray(ghosts);
  }
  return piece;
}

std::vector<Grid> scattered(
  vtkHyperTreeGrid* whole, const std::vector<int>& owners, Others others = Others::Masked)
{
  const int count = *std::ranges::max_element(owners) + 1;
  std::vector<Grid> pieces;
  for (int p = 0; p < count; ++p)
  {
    const bool hasCells = std::ranges::find(owners, p) != owners.end();
    pieces.push_back(!hasCells
        ? Grid{}
        : pieceOf(
            whole, [&](const Place& place) { return owners[hashOf(place) % owners.size()] == p; }, others));
  }
  return pieces;
}

/// Parts of the order of trees and their leaves, as simulations have them.
std::vector<Grid> alongCurve(vtkHyperTreeGrid* whole, int count)
{
  std::map<Place, std::size_t> order;
  forEachCounted(whole, [&](const Place& place, vtkIdType) { order.emplace(place, order.size()); });
  std::vector<Grid> pieces;
  for (int p = 0; p < count; ++p)
  {
    pieces.push_back(pieceOf(whole, [&](const Place& place) {
      return order.at(place) * static_cast<std::size_t>(count) / order.size() == static_cast<std::size_t>(p);
    }));
  }
  return pieces;
}

struct Result
{
  std::vector<ExchangedGrid> grids;
  std::vector<std::string> errors;
  std::size_t sent;
};

Result exchange(const std::vector<Grid>& pieces, const ExchangeOptions& options = {})
{
  Result result{ std::vector<ExchangedGrid>(pieces.size()), std::vector<std::string>(pieces.size()), 0 };
  result.sent = runProcesses(static_cast<int>(pieces.size()), [&](vtkMultiProcessController& controller) {
    const auto own = static_cast<std::size_t>(controller.GetLocalProcessId());
    try
    {
      result.grids[own] = exchangeGrid(pieces[own], &controller, options);
    }
    catch (const std::exception& error)
    {
      result.errors[own] = error.what();
    }
  });
  return result;
}

/// Whether results are the boxes of a grid.
void expectBoxesOf(vtkHyperTreeGrid* whole, const Result& result, int mirrored = 0)
{
  const auto expected = countedCells(whole, mirrored);
  std::map<Place, std::string> found;
  VertexDifferences differences;
  const auto field = acquireField(whole, { "scalar", 0 });
  for (std::size_t p = 0; p < result.grids.size(); ++p)
  {
    ASSERT_EQ(result.errors[p], "") << p;
    vtkHyperTreeGrid* const grid = result.grids[p].grid;
    EXPECT_TRUE(result.grids[p].leftOut.empty());
    const auto partition = partitionOf(*grid);
    ASSERT_TRUE(partition);
    EXPECT_EQ(partition->own, static_cast<int>(p));
    EXPECT_EQ(partition->boxes, partitionOf(*result.grids[0].grid)->boxes);
    for (const auto& [place, bytes] : countedCells(grid))
    {
      EXPECT_TRUE(found.emplace(place, bytes).second);
    }
    if (countVertices(grid) > 0)
    {
      differences.compare(*field, *acquireField(grid, { "scalar", 0 }), partition->box());
    }
  }
  EXPECT_EQ(found.size(), expected.size());
  EXPECT_TRUE(found == expected);
  EXPECT_GT(differences.compared, 100u);
  EXPECT_EQ(differences.missing, 0u);
  EXPECT_EQ(differences.values, 0u) << "of " << differences.compared;
  EXPECT_EQ(differences.gradients, 0u) << "of " << differences.compared;
}

std::string errorOnAll(const std::vector<Grid>& pieces)
{
  const Result result = exchange(pieces);
  for (const std::string& error : result.errors)
  {
    EXPECT_EQ(error, result.errors[0]);
  }
  return result.errors[0];
}

void expectIn(const std::string& text, const std::string& part)
{
  EXPECT_NE(text.find(part), std::string::npos) << text;
}

template <class Array>
void addNumbers(vtkHyperTreeGrid* grid, const char* name)
{
  vtkNew<Array> array;
  array->SetName(name);
  array->SetNumberOfComponents(2);
  array->SetNumberOfTuples(countVertices(grid));
  for (vtkIdType i = 0; i < 2 * countVertices(grid); ++i)
  {
    array->SetValue(i, static_cast<typename Array::ValueType>(3 * i + 1));
  }
  grid->GetCellData()->AddArray(array);
}

} // namespace

TEST(GridExchange, CellsOfAnyProcessesComeToTheirBoxes)
{
  std::vector<RandomHyperTreeGrid> all(9);
  all[1] = { .seed = 2, .missingTrees = 0.3, .masked = 0.1 };
  all[2] = { .seed = 3, .transposedRoots = true };
  all[3] = { .seed = 4, .explicitIndices = true };
  all[4] = { .seed = 5, .uniform = true };
  all[5] = { .seed = 21, .roots = { 1, 1, 1 }, .levels = 5, .refine = 0.8, .masked = 0.02 };
  all[6] = { .seed = 7, .levels = 5, .refine = 0.6, .masked = 0.05 };
  all[7] = { .seed = 8, .depthLimit = 3 };
  all[8] = { .seed = 9, .refine = 0.6, .notFinite = 0.05 };
  for (const RandomHyperTreeGrid& options : all)
  {
    SCOPED_TRACE(options.seed);
    const auto whole = makeGrid(options);
    expectBoxesOf(whole, exchange(scattered(whole, { 0, 1 })));
    expectBoxesOf(whole, exchange(scattered(whole, { 0, 1, 2 }, Others::Ghosts)));
    expectBoxesOf(whole, exchange(scattered(whole, { 0, 0, 0, 1, 4 }))); // two have none
    expectBoxesOf(whole, exchange(alongCurve(whole, 8)));
  }
}

TEST(GridExchange, AxesMayBeTurned)
{
  for (const int mirrored : { 1, 6, 7 })
  {
    const auto whole = makeGrid({ .mirrored = mirrored });
    vtkNew<vtkDoubleArray> corners;
    corners->SetName("corners");
    markAsCorners(*corners);
    corners->SetNumberOfTuples(countVertices(whole));
    std::iota(corners->GetPointer(0), corners->GetPointer(0) + corners->GetNumberOfValues(), 1.);
    whole->GetCellData()->AddArray(corners);
    const Result result = exchange(scattered(whole, { 0, 1, 2 }));
    expectBoxesOf(whole, result, mirrored);
    EXPECT_TRUE(isAtCorners(*result.grids[1].grid->GetCellData()->GetArray("corners")));
  }
}

TEST(GridExchange, AllOnOneProcess)
{
  const auto whole = makeGrid({ .seed = 11 });
  expectBoxesOf(whole, exchange({ nullptr, whole, Grid::New() }));
}

TEST(GridExchange, WholeCopiesAreOneGridOfWhichNothingIsSentButBorders)
{
  const auto whole = makeUniformlyRefinedGrid(5);
  const auto copy = [&] {
    const auto grid = Grid::New();
    grid->DeepCopy(whole);
    return grid;
  };
  const Result ofCopies = exchange({ copy(), copy(), copy() });
  expectBoxesOf(whole, ofCopies);
  const Result ofOne = exchange({ copy(), nullptr, nullptr });
  expectBoxesOf(whole, ofOne);
  constexpr std::size_t bytes = 16; // key and value
  EXPECT_LT(ofCopies.sent + 32 * 32 * 32 * 6 / 10 * bytes, ofOne.sent);
  // And with one that has another part of it.
  const auto half = pieceOf(whole, [](const Place& place) { return hashOf(place) % 2 == 0; });
  expectBoxesOf(whole, exchange({ copy(), half, copy(), nullptr }));
}

TEST(GridExchange, OfCellsThatSeveralCountTheFirstProcessHas)
{
  const auto whole = makeGrid({ .seed = 12 });
  auto pieces = scattered(whole, { 0, 1 });
  const auto other = Grid::New();
  other->DeepCopy(whole);
  auto* const scalar = vtkDoubleArray::SafeDownCast(other->GetCellData()->GetArray("scalar"));
  std::fill_n(scalar->GetPointer(0), scalar->GetNumberOfTuples(), 7.);
  expectBoxesOf(whole, exchange({ pieces[0], pieces[1], other }));
}

TEST(GridExchange, ArraysOfAllTypesKeepTypeNamesAndBits)
{
  const auto whole = makeGrid({ .seed = 13 });
  addNumbers<vtkSignedCharArray>(whole, "i8");
  addNumbers<vtkUnsignedCharArray>(whole, "u8");
  addNumbers<vtkShortArray>(whole, "i16");
  addNumbers<vtkUnsignedShortArray>(whole, "u16");
  addNumbers<vtkUnsignedIntArray>(whole, "u32");
  addNumbers<vtkLongArray>(whole, "i64");
  addNumbers<vtkUnsignedLongLongArray>(whole, "u64");
  addNumbers<vtkIdTypeArray>(whole, "id");
  whole->GetCellData()->GetArray("i16")->SetComponentName(1, "second");
  whole->GetCellData()->SetActiveScalars("u8");
  vtkNew<vtkIntArray> cycle;
  cycle->SetName("cycle");
  cycle->InsertNextValue(42);
  const auto pieces = scattered(whole, { 0, 1, 2 });
  pieces[1]->GetFieldData()->AddArray(cycle);
  const Result result = exchange(pieces);
  expectBoxesOf(whole, result);
  for (const ExchangedGrid& made : result.grids)
  {
    vtkCellData* const data = made.grid->GetCellData();
    for (int i = 0; i < whole->GetCellData()->GetNumberOfArrays(); ++i)
    {
      EXPECT_EQ(data->GetArray(i)->GetDataType(), whole->GetCellData()->GetArray(i)->GetDataType());
    }
    EXPECT_STREQ(data->GetArray("i16")->GetComponentName(1), "second");
    EXPECT_STREQ(data->GetScalars()->GetName(), "u8");
  }
  EXPECT_TRUE(result.grids[1].grid->GetFieldData()->HasArray("cycle"));
  EXPECT_FALSE(result.grids[0].grid->GetFieldData()->HasArray("cycle"));
}

TEST(GridExchange, ArraysThatNotAllHaveAreLeftOut)
{
  const auto whole = makeGrid({ .seed = 14 });
  const auto pieces = scattered(whole, { 0, 1, 2 });
  pieces[1]->GetCellData()->RemoveArray("vector");
  addNumbers<vtkSignedCharArray>(pieces[2], "own");
  vtkNew<vtkStringArray> names;
  names->SetName("names");
  names->SetNumberOfValues(countVertices(pieces[2]));
  pieces[2]->GetCellData()->AddArray(names);
  const Result result = exchange(pieces);
  const std::string vector = "cell array 'vector' is not alike on all processes";
  EXPECT_EQ(result.grids[0].leftOut, std::vector<std::string>{ vector });
  EXPECT_TRUE(result.grids[1].leftOut.empty());
  EXPECT_EQ(result.grids[2].leftOut,
    (std::vector<std::string>{
      vector, "cell array 'own' is not alike on all processes", "cell array 'names' is not of numbers" }));
  const Result some = exchange(pieces, { .arrays = { "count", "none" } });
  EXPECT_EQ(some.grids[2].grid->GetCellData()->GetNumberOfArrays(), 2); // with vtkGhostType
  EXPECT_TRUE(some.grids[2].grid->GetCellData()->HasArray("count"));
  EXPECT_TRUE(some.grids[2].leftOut.empty());
}

TEST(GridExchange, TellsWhereCellsCameFrom)
{
  const auto whole = makeGrid({ .seed = 15 });
  const auto pieces = scattered(whole, { 0, 1, 2 });
  const Result result = exchange(pieces, { .keepsOrigins = true });
  std::size_t compared = 0;
  for (const ExchangedGrid& made : result.grids)
  {
    auto* const values = vtkDoubleArray::SafeDownCast(made.grid->GetCellData()->GetArray("scalar"));
    forEachCounted(made.grid, [&](const Place& place, vtkIdType index) {
      const CellOrigin origin = cellOrigin(*made.grid, index, 99);
      EXPECT_EQ(origin.process, static_cast<int>(hashOf(place) % 3));
      auto* const from = vtkDoubleArray::SafeDownCast(
        pieces[static_cast<std::size_t>(origin.process)]->GetCellData()->GetArray("scalar"));
      EXPECT_EQ(values->GetValue(index), from->GetValue(origin.index));
      ++compared;
    });
  }
  EXPECT_GT(compared, 100u);
  EXPECT_EQ(cellOrigin(*whole, 5, 2).process, 2);
  EXPECT_EQ(cellOrigin(*whole, 5, 2).index, 5);
}

TEST(GridExchange, GridsThatArePartitionedOrAloneComeBackThemselves)
{
  const auto whole = makeGrid({ .seed = 16 });
  const auto pieces = scattered(whole, { 0, 1, 2 });
  const Result once = exchange(pieces);
  std::vector<Grid> made;
  for (const ExchangedGrid& grid : once.grids)
  {
    made.push_back(grid.grid);
  }
  const Result twice = exchange(made);
  for (std::size_t p = 0; p < made.size(); ++p)
  {
    // Not copied: arrays and trees are the same.
    EXPECT_EQ(twice.grids[p].grid->GetCellData()->GetArray(0), made[p]->GetCellData()->GetArray(0));
    EXPECT_EQ(partitionOf(*twice.grids[p].grid), partitionOf(*made[p]));
  }
  // Those of another number of processes are partitioned again.
  expectBoxesOf(whole, exchange({ made[0], made[1], made[2], nullptr }));
  // So are those of which one has another process' box.
  expectBoxesOf(whole, exchange({ made[1], made[0], made[2] }));

  EXPECT_EQ(exchange({ whole }).grids[0].grid, whole);
  const auto empty = Grid::New();
  const Result ofNone = exchange({ empty, nullptr, empty });
  EXPECT_EQ(ofNone.errors[0], "");
  EXPECT_EQ(ofNone.grids[0].grid, empty);
  EXPECT_EQ(ofNone.grids[1].grid, nullptr);
}

TEST(GridExchange, MoreProcessesThanCellsLeaveSomeWithoutTrees)
{
  const auto one = makeUniformlyRefinedGrid(0);
  const Result result = exchange({ nullptr, one, nullptr });
  std::size_t cells = 0;
  for (const ExchangedGrid& made : result.grids)
  {
    ASSERT_TRUE(made.grid);
    EXPECT_TRUE(partitionOf(*made.grid));
    cells += countedCells(made.grid).size();
  }
  EXPECT_EQ(cells, 1u);
}

TEST(GridExchange, AnErrorOfOneProcessIsOneOfAll)
{
  const auto whole = makeGrid({ .seed = 17 });
  const auto pieces = scattered(whole, { 0, 1, 2 });
  expectIn(errorOnAll({ pieces[0], pieces[1], makeGrid({ .seed = 17, .roots = { 2, 3, 3 } }) }),
    "hyper tree grid of process 2: its lattice of 2 x 3 x 3 roots is not that of process 0, of 2 x 3 x 2; "
    "allowed are the same");

  vtkNew<vtkHyperTreeGrid> ofThree;
  ofThree->SetBranchFactor(3);
  ofThree->SetDimensions(std::array<unsigned int, 3>{ 3, 4, 3 }.data());
  ofThree->SetXCoordinates(whole->GetXCoordinates());
  ofThree->SetYCoordinates(whole->GetYCoordinates());
  ofThree->SetZCoordinates(whole->GetZCoordinates());
  ofThree->GetTree(0, true)->SetGlobalIndexStart(0);
  expectIn(errorOnAll({ pieces[0], ofThree.Get(), pieces[2] }),
    "process 1: hyper tree grid: its branch factor is 3, allowed is 2");

  const auto tooFew = Grid::New();
  tooFew->DeepCopy(pieces[1]);
  tooFew->GetCellData()->GetArray("scalar")->SetNumberOfTuples(5);
  expectIn(errorOnAll({ pieces[0], tooFew, pieces[2] }),
    "process 1: hyper tree grid: cell array 'scalar' has 5 tuples");
}

TEST(GridExchange, CellsOfDifferentLevelsMayNotOverlap)
{
  expectIn(errorOnAll({ makeUniformlyRefinedGrid(2), makeUniformlyRefinedGrid(3), nullptr }),
    "hyper tree grids of processes 0 and 1: cells of different levels overlap at ");
}

TEST(GridExchange, WithoutMemoryOnOneProcessAllEnd)
{
  const auto pieces = scattered(makeUniformlyRefinedGrid(4), { 0, 1, 2 });
  int failures = 0;
  for (bool isComplete = false; !isComplete;)
  {
    std::vector<std::string> errors(pieces.size());
    runProcesses(3, [&](vtkMultiProcessController& controller) {
      const auto own = static_cast<std::size_t>(controller.GetLocalProcessId());
      hasFailed = false;
      untilFailure = own == 2 ? failures + 1 : 0;
      try
      {
        exchangeGrid(pieces[own], &controller);
      }
      catch (const std::exception& error)
      {
        errors[own] = error.what();
      }
      untilFailure = 0;
      if (own == 2)
      {
        isComplete = !hasFailed;
      }
    });
    for (const std::string& error : errors)
    {
      ASSERT_EQ(error, isComplete ? "" : "process 2: not enough memory") << "after " << failures;
    }
    ++failures;
  }
  EXPECT_GT(failures, 10);
}

TEST(RedistributeGrid, MakesTheGridOfABoxOfWhatAllProcessesHave)
{
  const auto whole = makeGrid({ .seed = 18 });
  auto pieces = scattered(whole, { 0, 1 });
  pieces.push_back(Grid::New());
  vtkNew<vtkIntArray> cycle;
  cycle->SetName("cycle");
  cycle->InsertNextValue(42);
  pieces[0]->GetFieldData()->AddArray(cycle);
  for (const bool isRight : { true, false })
  {
    if (!isRight)
    {
      pieces[1]->GetCellData()->GetArray("scalar")->SetNumberOfTuples(5);
    }
    std::vector<std::vector<std::string>> errors(3);
    Result result{ std::vector<ExchangedGrid>(3), std::vector<std::string>(3), 0 };
    runProcesses(3, [&](vtkMultiProcessController& controller) {
      const auto own = static_cast<std::size_t>(controller.GetLocalProcessId());
      vtkNew<vtkTreeAMRRedistributeGrid> filter;
      const MessageCatcher messages(filter, vtkCommand::ErrorEvent);
      filter->SetController(&controller);
      filter->SetInputDataObject(pieces[own]);
      filter->Update();
      errors[own] = messages.messages();
      result.grids[own].grid = vtkHyperTreeGrid::SafeDownCast(filter->GetOutputDataObject(0));
    });
    for (std::size_t p = 0; p < 3; ++p)
    {
      EXPECT_EQ(errors[p].size(), isRight ? 0u : 1u);
      EXPECT_EQ(result.grids[p].grid->GetFieldData()->HasArray("cycle"), p == 0);
      if (!isRight)
      {
        expectIn(
          errors[p].at(0), "redistribution: process 1: hyper tree grid: cell array 'scalar' has 5 tuples");
        EXPECT_EQ(countVertices(result.grids[p].grid), 0);
      }
    }
    if (isRight)
    {
      expectBoxesOf(whole, result);
    }
  }
}
