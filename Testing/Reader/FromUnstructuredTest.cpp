// Octrees exported as hexahedra come back as they were, cell by cell; what is no octree is an error that says which cell.
#include "vtkTreeAMRFromUnstructured.h"
#include "vtkTreeAMRP4estReader.h"

#include "CornerArrays.h"
#include "Field/CornerValues.h"
#include "Interpolation/Sampler.h"
#include "Support/CornerFunction.h"
#include "Support/GridMakers.h"
#include "Support/Hexahedra.h"
#include "Support/HyperTreeGrids.h"
#include "Support/RandomTrees.h"

#include "vtkBitArray.h"
#include "vtkCellArray.h"
#include "vtkCellData.h"
#include "vtkCellType.h"
#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkDoubleArray.h"
#include "vtkFieldData.h"
#include "vtkFloatArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkHyperTreeGridNonOrientedCursor.h"
#include "vtkIdTypeArray.h"
#include "vtkImageData.h"
#include "vtkIntArray.h"
#include "vtkMultiBlockDataSet.h"
#include "vtkNew.h"
#include "vtkPartitionedDataSet.h"
#include "vtkPartitionedDataSetCollection.h"
#include "vtkPointData.h"
#include "vtkPointDataToCellData.h"
#include "vtkPoints.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkStringArray.h"
#include "vtkTrivialProducer.h"
#include "vtkUnsignedCharArray.h"
#include "vtkUnstructuredGrid.h"
#include "vtkVersionMacros.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

MadeGrid convert(vtkDataObject* input)
{
  return makeGridBy<vtkTreeAMRFromUnstructured>(input);
}

std::string errorOf(vtkDataObject* input)
{
  return test::errorOf<vtkTreeAMRFromUnstructured>(input);
}

/// Calls visit(global index, those of its children that are not masked) at each coarse cell.
void forEachNode(
  vtkHyperTreeGrid* grid, const std::function<void(vtkIdType, const std::vector<vtkIdType>&)>& visit)
{
  vtkHyperTreeGrid::vtkHyperTreeGridIterator trees;
  grid->InitializeTreeIterator(trees);
  vtkIdType tree = 0;
  while (trees.GetNextTree(tree))
  {
    vtkNew<vtkHyperTreeGridNonOrientedCursor> cursor;
    grid->InitializeNonOrientedCursor(cursor, tree);
    const std::function<void()> walk = [&] {
      if (cursor->IsLeaf())
      {
        return;
      }
      std::vector<vtkIdType> children;
      for (unsigned char o = 0; o < 8; ++o)
      {
        cursor->ToChild(o);
        if (!cursor->IsMasked())
        {
          children.push_back(cursor->GetGlobalNodeIndex());
          walk();
        }
        cursor->ToParent();
      }
      visit(cursor->GetGlobalNodeIndex(), children);
    };
    walk();
  }
}

/// The leaves are the cells, with their values.
void expectCells(vtkHyperTreeGrid* grid, const std::vector<CellId>& cells, const HexahedronExport& options)
{
  vtkCellData* const data = grid->GetCellData();
  ASSERT_TRUE(vtkIntArray::SafeDownCast(data->GetArray("number")));
  ASSERT_TRUE(vtkDoubleArray::SafeDownCast(data->GetArray("hash")));
  ASSERT_EQ(data->GetArray("hash")->GetNumberOfComponents(), 3);
  EXPECT_STREQ(data->GetArray("hash")->GetComponentName(1), "second");
  std::vector<int> seen(cells.size(), 0);
  int wrong = 0;
  forEachLeaf(grid, [&](const double* bounds, vtkIdType id) {
    const auto number = static_cast<int>(data->GetArray("number")->GetComponent(id, 0));
    ASSERT_LT(number, static_cast<int>(cells.size()));
    ++seen[number];
    const CellId& cell = cells[number];
    for (int a = 0; a < 3; ++a)
    {
      const double width = std::ldexp(options.rootSize[a], -cell.level);
      const double low = options.origin[a] + static_cast<double>(cell.index[a]) * width;
      const double allowed = options.floats || options.scale < 1. ? width / 8. : width * 1e-4;
      wrong +=
        !(std::abs(bounds[2 * a] - low) < allowed && std::abs(bounds[2 * a + 1] - low - width) < allowed);
      wrong += data->GetArray("hash")->GetComponent(id, a) != hashOf(number, a);
    }
  });
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(std::ranges::count(seen, 1), static_cast<std::ptrdiff_t>(cells.size()));
}

std::vector<CellId> cellsOf(const RandomTree& tree)
{
  std::vector<CellId> cells;
  for (const LeafCell& leaf : makeRandomTree(tree))
  {
    cells.push_back(leaf.cell);
  }
  return cells;
}

/// As deal.II's DataOut writes the cells of an octree: each of them as n^3.
std::vector<CellId> patchesOf(const std::vector<CellId>& cells, Coord n)
{
  std::vector<CellId> patches;
  for (const CellId& cell : cells)
  {
    for (Coord i = 0; i < n * n * n; ++i)
    {
      patches.push_back(
        { { n * cell.index[0] + i % n, n * cell.index[1] + i / n % n, n * cell.index[2] + i / n / n },
          cell.level });
    }
  }
  return patches;
}

void expectRoundTrip(const std::vector<CellId>& cells, const HexahedronExport& options)
{
  const MadeGrid result = convert(makeHexahedra(cells, options));
  ASSERT_TRUE(result.errors.empty()) << result.errors[0];
  expectCells(result.grid, cells, options);
}

/// Eight cells of half a root, in the first of two roots, and the second root.
std::vector<CellId> nineCells()
{
  std::vector<CellId> cells;
  for (int o = 0; o < 8; ++o)
  {
    cells.push_back({ indexOfChild({ 0, 0, 0 }, o), 1 });
  }
  cells.push_back({ { 1, 0, 0 }, 0 });
  return cells;
}

} // namespace

TEST(FromUnstructured, OctreesComeBack)
{
  std::uint32_t seed = 0;
  for (const RandomTree& tree : propertyTrees())
  {
    const std::vector<CellId> cells = cellsOf(tree);
    ++seed;
    HexahedronExport options;
    options.seed = seed % 4 == 0 ? 0 : seed;
    options.sharedPoints = seed % 2 == 0;
    options.floats = seed % 3 == 0;
    options.voxels = seed % 5 < 2;
    options.duplicates = seed % 4 == 1 ? 20 : 0;
    if (seed % 7 > 2)
    {
      options.origin = { -1. / 3., 1e3, 0.1 };
      options.rootSize = { 0.7, 1e2, 1. / 3. };
    }
    SCOPED_TRACE(seed);
    expectRoundTrip(cells, options);
  }
}

#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 6, 0)
// Offsets of as many points for each cell are computed, not stored.
TEST(FromUnstructured, CellsOfFixedSize)
{
  for (const auto convertCells :
    { &vtkCellArray::ConvertToFixedSize32BitStorage, &vtkCellArray::ConvertToFixedSize64BitStorage })
  {
    const std::vector<CellId> cells = nineCells();
    const HexahedronExport options;
    const auto grid = makeHexahedra(cells, options);
    ASSERT_TRUE((grid->GetCells()->*convertCells)());
    const MadeGrid result = convert(grid);
    ASSERT_TRUE(result.errors.empty()) << result.errors[0];
    expectCells(result.grid, cells, options);
  }
}
#endif

TEST(FromUnstructured, ShrunkCellsHaveTheirPlacesFilled)
{
  for (const bool floats : { false, true })
  {
    for (const double scale : { 0.95, 0.5 })
    {
      HexahedronExport options;
      options.scale = scale;
      options.floats = floats;
      options.seed = 3;
      options.rootSize = { 0.3, 1., 2. };
      RandomTree tree;
      tree.roots = { 3, 2, 1 };
      tree.levels = 5;
      expectRoundTrip(cellsOf(tree), options);
      expectRoundTrip(nineCells(), options);
    }
  }
}

TEST(FromUnstructured, DeepTrees)
{
  // Down to a corner, in doubles beyond what floats can tell; with several roots keys of more than a word.
  for (const int depth : { 19, 25, 31 })
  {
    for (const Coord roots : { 1, 3 })
    {
      std::vector<CellId> cells;
      for (Coord r = 1; r < roots; ++r)
      {
        cells.push_back({ { r, 0, 0 }, 0 });
      }
      for (int level = 1; level <= depth; ++level)
      {
        for (int o = level < depth ? 1 : 0; o < 8; ++o)
        {
          cells.push_back({ indexOfChild({ 0, 0, 0 }, o), level });
        }
      }
      HexahedronExport options;
      options.seed = 5;
      options.origin = { -0.7, 0., 0.1 };
      SCOPED_TRACE(depth);
      const MadeGrid result = convert(makeHexahedra(cells, options));
      if (roots == 1)
      {
        // The largest boxes are halves of the domain: there is one root of eight of them.
        EXPECT_EQ(result.grid->GetNumberOfNonEmptyTrees(), 1);
      }
      ASSERT_TRUE(result.errors.empty()) << result.errors[0];
      expectCells(result.grid, cells, options);
    }
  }
}

TEST(FromUnstructured, RootsAreJoinedWhileTheirNumbersAreEvenOrLarge)
{
  for (const auto& [roots, joined] :
    { std::pair<std::array<int, 3>, std::array<int, 3>>{ { 8, 8, 8 }, { 1, 1, 1 } },
      { { 12, 4, 8 }, { 3, 1, 2 } }, { { 3, 4, 4 }, { 3, 4, 4 } }, { { 43, 41, 40 }, { 22, 21, 20 } } })
  {
    RandomTree tree;
    tree.roots = roots;
    tree.levels = 0;
    HexahedronExport options;
    options.origin = { 0.1, 0.2, 0.3 };
    options.rootSize = { 0.1, 0.1, 0.1 };
    const std::vector<CellId> cells = cellsOf(tree);
    const MadeGrid result = convert(makeHexahedra(cells, options));
    ASSERT_TRUE(result.errors.empty()) << result.errors[0];
    expectCells(result.grid, cells, options);
    const unsigned int* const dimensions = result.grid->GetDimensions();
    for (int a = 0; a < 3; ++a)
    {
      EXPECT_EQ(dimensions[a], joined[a] + 1u);
    }
    // The ends are the cells' own coordinates.
    const std::array<double, 6> bounds = latticeBounds(result.grid);
    EXPECT_EQ(bounds[0], 0.1);
    const bool many = roots[0] == 43; // so that they are joined though their numbers are odd
    EXPECT_DOUBLE_EQ(bounds[1], 0.1 + (roots[0] + many) * 0.1);
    EXPECT_EQ(bounds[5], 0.3 + roots[2] * 0.1);
  }
}

TEST(FromUnstructured, SplitPatches)
{
  RandomTree tree;
  tree.roots = { 2, 1, 1 };
  tree.levels = 3;
  for (const Coord n : { 2, 3, 4, 5 })
  {
    const std::vector<CellId> cells = patchesOf(cellsOf(tree), n);
    HexahedronExport options;
    for (double& size : options.rootSize)
    {
      size = 1. / static_cast<double>(n);
    }
    SCOPED_TRACE(n);
    options.floats = true;
    expectRoundTrip(cells, options);
  }
}

TEST(FromUnstructured, RoundedToSixDigits)
{
  RandomTree tree;
  tree.roots = { 3, 3, 2 };
  tree.levels = 4;
  const std::vector<CellId> cells = cellsOf(tree);
  HexahedronExport options;
  options.origin = { 1. / 3., 12345., -1. / 7. };
  options.rootSize = { 1. / 3., 1000., 1. / 7. };
  const auto grid = makeHexahedra(cells, options);
  for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i)
  {
    std::array<double, 3> p;
    grid->GetPoint(i, p.data());
    for (double& x : p)
    {
      char text[32];
      std::snprintf(text, sizeof(text), "%g", x);
      x = std::strtod(text, nullptr);
    }
    grid->GetPoints()->SetPoint(i, p.data());
  }
  const MadeGrid result = convert(grid);
  ASSERT_TRUE(result.errors.empty()) << result.errors[0];
  options.floats = true; // not exact
  expectCells(result.grid, cells, options);
}

TEST(FromUnstructured, OneCellAndNone)
{
  expectRoundTrip({ { { 0, 0, 0 }, 0 } }, {});
  vtkNew<vtkUnstructuredGrid> empty;
  const MadeGrid none = convert(empty);
  EXPECT_TRUE(none.errors.empty());
  EXPECT_EQ(none.grid->GetNumberOfNonEmptyTrees(), 0);
  vtkNew<vtkMultiBlockDataSet> blocks;
  blocks->SetBlock(0, empty);
  blocks->SetBlock(3, nullptr);
  EXPECT_TRUE(convert(blocks).errors.empty());
}

TEST(FromUnstructured, CollectionsAreOneGrid)
{
  RandomTree tree;
  tree.roots = { 2, 2, 2 };
  const std::vector<CellId> cells = cellsOf(tree);
  HexahedronExport options;
  options.seed = 1;
  const auto whole = makeHexahedra(cells, options);
  // The blocks' cells keep their numbers among all; some are in two blocks.
  std::array<vtkSmartPointer<vtkUnstructuredGrid>, 3> parts;
  for (std::size_t p = 0; p < 3; ++p)
  {
    parts[p] = vtkSmartPointer<vtkUnstructuredGrid>::New();
    parts[p]->SetPoints(whole->GetPoints());
    parts[p]->Allocate(1);
    parts[p]->GetCellData()->CopyAllocate(whole->GetCellData());
    for (vtkIdType i = 0; i < whole->GetNumberOfCells(); ++i)
    {
      if (static_cast<std::size_t>(i) % 3 == p || static_cast<std::size_t>(i) % 7 == p)
      {
        const vtkIdType cell =
          parts[p]->InsertNextCell(whole->GetCellType(i), whole->GetCell(i)->GetPointIds());
        parts[p]->GetCellData()->CopyData(whole->GetCellData(), i, cell);
      }
    }
  }
  vtkNew<vtkMultiBlockDataSet> blocks;
  vtkNew<vtkPartitionedDataSet> partitions;
  for (unsigned int p = 0; p < 3; ++p)
  {
    blocks->SetBlock(2 * p, parts[p]);
    partitions->SetPartition(p, parts[p]);
  }
  vtkNew<vtkPartitionedDataSetCollection> collection;
  collection->SetPartitionedDataSet(0, partitions);
  for (vtkDataObject* const input : { static_cast<vtkDataObject*>(blocks),
         static_cast<vtkDataObject*>(partitions), static_cast<vtkDataObject*>(collection) })
  {
    const MadeGrid result = convert(input);
    ASSERT_TRUE(result.errors.empty()) << result.errors[0];
    expectCells(result.grid, cells, options);
  }
  // What one block lacks is named.
  parts[1]->GetCellData()->RemoveArray("hash");
  const MadeGrid partial = convert(blocks);
  EXPECT_TRUE(partial.errors.empty());
  ASSERT_EQ(partial.warnings.size(), 1u);
  expectIn(partial.warnings[0], "cell array 'hash' is not in block 3");
  EXPECT_FALSE(partial.grid->GetCellData()->HasArray("hash"));

  vtkNew<vtkImageData> image;
  image->SetDimensions(2, 2, 2);
  blocks->SetBlock(1, image);
  expectIn(errorOf(blocks), "block 2 is a vtkImageData, allowed is vtkUnstructuredGrid");
}

TEST(FromUnstructured, GhostsAreLeftOut)
{
  const std::vector<CellId> cells = nineCells();
  const auto input = makeHexahedra(cells, {});
  vtkNew<vtkUnsignedCharArray> ghosts;
  ghosts->SetName(vtkDataSetAttributes::GhostArrayName());
  for (int i = 0; i < 9; ++i)
  {
    ghosts->InsertNextValue(i == 2 ? vtkDataSetAttributes::DUPLICATECELL
        : i == 4                   ? vtkDataSetAttributes::HIDDENCELL
        : i == 5                   ? vtkDataSetAttributes::EXTERIORCELL
                                   : 0);
  }
  input->GetCellData()->AddArray(ghosts);
  const MadeGrid result = convert(input);
  std::vector<int> numbers;
  forEachLeaf(result.grid, [&](const double*, vtkIdType id) {
    numbers.push_back(static_cast<int>(result.grid->GetCellData()->GetArray("number")->GetComponent(id, 0)));
  });
  EXPECT_EQ(numbers, (std::vector<int>{ 0, 1, 3, 5, 6, 7, 8 }));
  EXPECT_FALSE(result.grid->GetCellData()->HasArray(vtkDataSetAttributes::GhostArrayName()));
  EXPECT_TRUE(result.errors.empty());
  // None but ghosts.
  ghosts->FillComponent(0, vtkDataSetAttributes::DUPLICATECELL);
  EXPECT_TRUE(convert(input).errors.empty());
}

TEST(FromUnstructured, ArraysKeepTheirTypes)
{
  const std::vector<CellId> cells = nineCells();
  const auto input = makeHexahedra(cells, {});
  vtkCellData* const data = input->GetCellData();
  std::vector<int> types{ VTK_FLOAT, VTK_CHAR, VTK_SIGNED_CHAR, VTK_UNSIGNED_CHAR, VTK_SHORT, VTK_LONG,
    VTK_UNSIGNED_LONG, VTK_LONG_LONG, VTK_ID_TYPE, VTK_STRING, VTK_BIT };
  for (const int type : types)
  {
    const auto array = vtk::TakeSmartPointer(vtkAbstractArray::CreateArray(type));
    array->SetName(("type" + std::to_string(type)).c_str());
    array->SetNumberOfComponents(type == VTK_BIT ? 1 : 2);
    array->SetNumberOfTuples(9);
    for (vtkIdType i = 0; i < array->GetNumberOfValues(); ++i)
    {
      array->SetVariantValue(
        i, type == VTK_STRING ? vtkVariant(std::to_string(i)) : vtkVariant(static_cast<int>(i % 2)));
    }
    data->AddArray(array);
  }
  data->SetActiveScalars("hash");
  vtkNew<vtkDoubleArray> time;
  time->SetName("TimeValue");
  time->InsertNextValue(2.5);
  input->GetFieldData()->AddArray(time);
  const MadeGrid result = convert(input);
  vtkCellData* const out = result.grid->GetCellData();
  EXPECT_STREQ(out->GetScalars()->GetName(), "hash");
  EXPECT_TRUE(result.grid->GetFieldData()->HasArray("TimeValue"));
  for (const int type : types)
  {
    const std::string name = "type" + std::to_string(type);
    vtkAbstractArray* const array = out->GetAbstractArray(name.c_str());
    ASSERT_TRUE(array) << name;
    EXPECT_EQ(array->GetDataType(), type);
    EXPECT_STREQ(array->GetClassName(), data->GetAbstractArray(name.c_str())->GetClassName());
    EXPECT_EQ(array->GetNumberOfTuples(), countVertices(result.grid));
    forEachLeaf(result.grid, [&](const double*, vtkIdType id) {
      const auto number = static_cast<vtkIdType>(out->GetArray("number")->GetComponent(id, 0));
      const int components = array->GetNumberOfComponents();
      for (int c = 0; c < components; ++c)
      {
        EXPECT_EQ(array->GetVariantValue(id * components + c).ToString(),
          data->GetAbstractArray(name.c_str())->GetVariantValue(number * components + c).ToString())
          << name;
      }
    });
  }
  // A coarse cell: the mean of its eight, and the first one's.
  double mean = 0.;
  for (int i = 0; i < 8; ++i)
  {
    mean += hashOf(i, 0) / 8.;
  }
  EXPECT_NEAR(out->GetArray("hash")->GetComponent(0, 0), mean, 1e-9 * mean);
  EXPECT_EQ(out->GetArray("number")->GetComponent(0, 0), 0.);
}

TEST(FromUnstructured, CoarseCellsHaveTheMeanOfTheirChildren)
{
  // So many cells that several parts of them are worked on, trees and coarse cells reaching over parts.
  for (const double missing : { 0., 0.3 })
  {
    RandomTree tree;
    tree.roots = { 3, 2, 1 };
    tree.levels = 6;
    tree.refine = 0.8;
    tree.missing = missing;
    const std::vector<CellId> cells = patchesOf(cellsOf(tree), 3);
    ASSERT_GT(cells.size(), 4u << 14);
    HexahedronExport options;
    options.seed = 2;
    const MadeGrid result = convert(makeHexahedra(cells, options));
    expectCells(result.grid, cells, options);
    EXPECT_EQ(result.grid->HasMask(), missing > 0.);
    vtkDataArray* const hash = result.grid->GetCellData()->GetArray("hash");
    vtkDataArray* const number = result.grid->GetCellData()->GetArray("number");
    int wrong = 0;
    int coarse = 0;
    forEachNode(result.grid, [&](vtkIdType node, const std::vector<vtkIdType>& children) {
      double sum = 0.;
      for (const vtkIdType child : children)
      {
        sum += hash->GetComponent(child, 2);
      }
      wrong += hash->GetComponent(node, 2) != sum / static_cast<double>(children.size());
      wrong += number->GetComponent(node, 0) != number->GetComponent(children.front(), 0);
      ++coarse;
    });
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(coarse, 10000);
  }
}

TEST(FromUnstructured, PointsAreAveragedAsVTKDoes)
{
  RandomTree tree;
  tree.roots = { 1, 2, 1 };
  const std::vector<CellId> cells = cellsOf(tree);
  HexahedronExport options;
  options.sharedPoints = true;
  const auto input = makeHexahedra(cells, options);
  std::mt19937 random(1);
  for (const int type : { VTK_FLOAT, VTK_INT, VTK_UNSIGNED_CHAR })
  {
    const auto array = vtk::TakeSmartPointer(vtkDataArray::CreateDataArray(type));
    array->SetName(("points" + std::to_string(type)).c_str());
    array->SetNumberOfComponents(2);
    array->SetNumberOfTuples(input->GetNumberOfPoints());
    for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i)
    {
      array->SetTuple2(i, random() % 1000 / 7., random() % 200);
    }
    input->GetPointData()->AddArray(array);
  }
  // The cells' own array of that name counts.
  vtkNew<vtkDoubleArray> number;
  number->DeepCopy(input->GetPointData()->GetArray("x"));
  number->SetName("number");
  input->GetPointData()->AddArray(number);

  const MadeGrid result = convert(input);
  ASSERT_EQ(result.warnings.size(), 2u);
  expectIn(result.warnings[0], "averaged to the cells: points10, points6, points3.");
  expectIn(result.warnings[1], "left out: point array 'number' has the name of a cell array.");
  vtkNew<vtkPointDataToCellData> averages;
  input->GetPointData()->RemoveArray("number");
  averages->SetInputData(input);
  averages->Update();
  vtkCellData* const expected = averages->GetOutput()->GetCellData();
  expectCells(result.grid, cells, options);
  forEachLeaf(result.grid, [&](const double*, vtkIdType id) {
    const auto cell =
      static_cast<vtkIdType>(result.grid->GetCellData()->GetArray("number")->GetComponent(id, 0));
    for (const char* name : { "points10", "points6", "points3" })
    {
      vtkDataArray* const array = result.grid->GetCellData()->GetArray(name);
      EXPECT_EQ(array->GetDataType(), expected->GetArray(name)->GetDataType());
      for (int c = 0; c < array->GetNumberOfComponents(); ++c)
      {
        EXPECT_EQ(array->GetComponent(id, c), expected->GetArray(name)->GetComponent(cell, c)) << name;
      }
    }
  });
  // Without arrays of cells, the points' active ones are the grid's.
  vtkNew<vtkUnstructuredGrid> pointsOnly;
  pointsOnly->CopyStructure(input);
  pointsOnly->GetPointData()->ShallowCopy(input->GetPointData());
  pointsOnly->GetPointData()->SetActiveScalars("points10");
  EXPECT_STREQ(convert(pointsOnly).grid->GetCellData()->GetScalars()->GetName(), "points10");
}

// Adds arrays of points: "q", the function, and "level", a value a cell, as deal.II leaves it, unless cells share points.
void addPointArrays(vtkUnstructuredGrid* grid, const std::vector<CellId>& cells,
  const HexahedronExport& options, const CornerFunction& function)
{
  vtkDataArray* const number = grid->GetCellData()->GetArray("number");
  vtkNew<vtkDoubleArray> q;
  q->SetName("q");
  q->SetNumberOfValues(grid->GetNumberOfPoints());
  vtkNew<vtkFloatArray> level;
  level->SetName("level");
  level->SetNumberOfValues(grid->GetNumberOfPoints());
  for (vtkIdType i = 0; i < grid->GetNumberOfCells(); ++i)
  {
    const CellId& cell = cells[static_cast<std::size_t>(number->GetComponent(i, 0))];
    const std::array<double, 8> corners = function.corners(cell);
    for (int p = 0; p < 8; ++p)
    {
      const vtkIdType point = grid->GetCell(i)->GetPointId(p);
      std::array<double, 3> at;
      grid->GetPoint(point, at.data());
      int corner = 0;
      for (int a = 0; a < 3; ++a)
      {
        const double place = std::ldexp((at[a] - options.origin[a]) / options.rootSize[a], cell.level);
        corner |= (place - static_cast<double>(cell.index[a]) > 0.5) << a;
      }
      q->SetValue(point, corners[corner]);
      level->SetValue(point, static_cast<float>(cell.level));
    }
  }
  grid->GetPointData()->AddArray(q);
  if (!options.sharedPoints)
  {
    grid->GetPointData()->AddArray(level);
  }
}

// The grid's "q" is the function at 10,000 points.
void expectFunction(const MadeGrid& result, const std::vector<CellId>& cells, const HexahedronExport& options,
  const CornerFunction& function)
{
  vtkDataArray* const array = result.grid->GetCellData()->GetArray("q");
  ASSERT_TRUE(isAtCorners(*array));
  EXPECT_EQ(array->GetDataType(), VTK_DOUBLE);
  const auto field = acquireField(result.grid, { "q" });
  ASSERT_TRUE(field->corners());
  std::array<double, 2> range; // that ParaView colours by
  array->GetFiniteRange(range.data(), -1);
  EXPECT_EQ(static_cast<float>(range[0]), field->range().min);
  EXPECT_EQ(static_cast<float>(range[1]), field->range().max);
  const auto sampler = Sampler::create(InterpolationMethod::GTI, field);
  std::mt19937 random(options.seed);
  std::uniform_real_distribution<double> uniform(0.001, 0.999);
  for (int i = 0; i < 10000; ++i)
  {
    const CellId& cell = cells[random() % cells.size()];
    std::array<double, 3> inRoots;
    std::array<double, 3> world;
    for (int a = 0; a < 3; ++a)
    {
      inRoots[a] = std::ldexp(static_cast<double>(cell.index[a]) + uniform(random), -cell.level);
      world[a] = options.origin[a] + options.rootSize[a] * inRoots[a];
    }
    FieldSample sample;
    ASSERT_TRUE(sampler->sample(world, sample));
    ASSERT_NEAR(sample.value, function.value(cell, inRoots), 2e-6); // 1e-6 of the range
  }
  // A coarse cell has the values at its own corners, of what is there.
  for (vtkIdType i = 0; i < array->GetNumberOfValues(); ++i)
  {
    ASSERT_LE(std::abs(array->GetComponent(i / 8, static_cast<int>(i % 8))), 1.);
  }
}

TEST(FromUnstructured, PointsAreCorners)
{
  int jumps = 0;
  for (const RandomTree& tree : { RandomTree{ 3, { 2, 1, 1 }, 5, 0.5, 0., false },
         RandomTree{ 4, { 1, 2, 2 }, 5, 0.6, 0.3, false }, RandomTree{ 5, { 2, 2, 1 }, 4, 0.7, 0., true } })
  {
    const std::vector<LeafCell> leaves = makeRandomTree(tree);
    const CornerFunction function(leaves, tree.seed);
    std::vector<CellId> cells;
    for (const LeafCell& leaf : leaves)
    {
      cells.push_back(leaf.cell);
      for (int corner = 0; corner < 8; ++corner)
      {
        jumps = std::max(jumps, function.jumpAt(leaf.cell, corner));
      }
    }
    for (const int variant : { 0, 1, 2 })
    {
      SCOPED_TRACE(variant);
      HexahedronExport options;
      options.origin = { -3., 0.5, 10. };
      options.rootSize = { 0.3, 1., 2. };
      options.seed = 1 + variant;
      options.sharedPoints = variant == 1;
      options.voxels = variant == 2;
      const auto input = makeHexahedra(cells, options);
      addPointArrays(input, cells, options, function);
      const MadeGrid result = convert(input);
      EXPECT_TRUE(result.warnings.empty()) << result.warnings[0];
      ASSERT_NO_FATAL_FAILURE(expectFunction(result, cells, options, function));
      if (!options.sharedPoints)
      {
        vtkCellData* const data = result.grid->GetCellData();
        ASSERT_EQ(data->GetArray("level")->GetNumberOfComponents(), 1);
        EXPECT_EQ(data->GetArray("level")->GetDataType(), VTK_FLOAT);
        forEachLeaf(result.grid, [&](const double*, vtkIdType id) {
          const auto cell = static_cast<std::size_t>(data->GetArray("number")->GetComponent(id, 0));
          EXPECT_EQ(data->GetArray("level")->GetComponent(id, 0), cells[cell].level);
        });
      }
    }
  }
  EXPECT_GE(jumps, 4);
}

TEST(FromUnstructured, PointArraysAreChosen)
{
  vtkNew<vtkTreeAMRFromUnstructured> filter;
  const auto input = makeHexahedra(nineCells(), {});
  filter->SetInputDataObject(input);
  const MessageCatcher warnings(filter, vtkCommand::WarningEvent);
  const auto hasX = [&] {
    filter->Update();
    return vtkHyperTreeGrid::SafeDownCast(filter->GetOutputDataObject(0))->GetCellData()->HasArray("x") != 0;
  };
  EXPECT_TRUE(hasX());
  filter->GetPointDataArraySelection()->DisableArray("x");
  filter->GetPointDataArraySelection()->EnableArray("other");
  EXPECT_FALSE(hasX());
  filter->GetPointDataArraySelection()->EnableArray("x");
  EXPECT_TRUE(hasX());
  ASSERT_EQ(warnings.messages().size(), 1u); // once
  expectIn(warnings.messages()[0], "no array of points is 'other', which is selected; there are 'x'.");
  filter->GetPointDataArraySelection()->RemoveAllArrays();
  filter->SelectionIsFinalOn();
  EXPECT_FALSE(hasX());
  EXPECT_TRUE(
    vtkHyperTreeGrid::SafeDownCast(filter->GetOutputDataObject(0))->GetCellData()->HasArray("number"));
}

TEST(FromUnstructured, MessagesComeOnce)
{
  vtkNew<vtkTreeAMRFromUnstructured> filter;
  const MessageCatcher warnings(filter, vtkCommand::WarningEvent);
  for (int i = 0; i < 3; ++i)
  {
    const auto input = makeHexahedra(nineCells(), {});
    vtkNew<vtkIntArray> number;
    number->SetName("averaged");
    number->SetNumberOfValues(input->GetNumberOfPoints());
    number->Fill(1);
    input->GetPointData()->AddArray(number);
    filter->SetInputDataObject(input);
    filter->Update();
  }
  EXPECT_EQ(warnings.messages().size(), 1u);
}

TEST(FromUnstructured, CellsThatFitNotAreNamed)
{
  const auto withPoint = [](vtkIdType cell, int corner, int axis, double shift) {
    const auto grid = makeHexahedra(nineCells(), {});
    const vtkIdType point = grid->GetCell(cell)->GetPointId(corner);
    std::array<double, 3> p;
    grid->GetPoint(point, p.data());
    p[axis] += shift;
    grid->GetPoints()->SetPoint(point, p.data());
    return grid;
  };
  // Sheared, not a number, flat.
  expectIn(errorOf(withPoint(3, 6, 0, 0.1)),
    "cell 3, which reaches from (0.5, 0.5, 0) to (1.1, 1, 0.5); allowed are");
  expectIn(errorOf(withPoint(5, 0, 1, std::nan(""))), "cell 5, which reaches from (0.5, nan, 0.5)");
  expectIn(errorOf(withPoint(5, 0, 1, 1. / 0.)), "cell 5, which reaches from (0.5, 0, 0.5) to (1, inf, 1)");
  expectIn(errorOf(withPoint(5, 0, 1, 1e-3)), "cell 5, ");

  const auto withBox = [](std::array<double, 3> low, std::array<double, 3> high) {
    const auto grid = makeHexahedra(nineCells(), {});
    std::array<vtkIdType, 8> ids;
    for (int o = 0; o < 8; ++o)
    {
      ids[o] = grid->GetPoints()->InsertNextPoint(
        sideOf(o, 0) ? high[0] : low[0], sideOf(o, 1) ? high[1] : low[1], sideOf(o, 2) ? high[2] : low[2]);
    }
    grid->InsertNextCell(VTK_VOXEL, 8, ids.data());
    for (const char* name : { "number", "hash" })
    {
      grid->GetCellData()->GetArray(name)->InsertNextTuple(0, grid->GetCellData()->GetArray(name));
    }
    grid->GetPointData()->RemoveArray("x");
    return grid;
  };
  // Off the lattice, a third wide, of other widths along the axes, flat, overlapping.
  expectIn(errorOf(withBox({ 2.25, 0., 0. }, { 2.75, 0.5, 0.5 })),
    "cell 9, which reaches from (2.25, 0, 0) to (2.75, 0.5, 0.5), fits no place of the lattice of the "
    "largest cells, "
    "which are (1, 1, 1) wide like that from (1, 0, 0) to (2, 1, 1)");
  expectIn(errorOf(withBox({ 2., 0., 0. }, { 2.33333, 0.33333, 0.33333 })), "cell 9, ");
  expectIn(errorOf(withBox({ 2., 0., 0. }, { 2.5, 0.5, 0.25 })), "cell 9, ");
  expectIn(errorOf(withBox({ 2., 0., 0. }, { 2.5, 0.5, 0. })), "cell 9, ");
  // Larger than those that are right, or as large as the largest of them.
  expectIn(errorOf(withBox({ 2., 0., 0. }, { 3.5, 1.5, 1.5 })), "cell 9, ");
  expectIn(errorOf(withBox({ 2.3, 0., 0. }, { 3.3, 1., 1. })), "cell 9, ");
  expectIn(errorOf(withBox({ 1., 0., 0. }, { 1.5, 0.5, 0.5 })),
    "cells overlap: cell 8, which reaches from (1, 0, 0) to (2, 1, 1), and cell 9, which reaches from (1, 0, "
    "0)");
  expectIn(errorOf(withBox({ 0., 0., 0. }, { 1., 1., 1. })),
    ", and cell 9, which reaches from (0, 0, 0) to (1, 1, 1)");
}

TEST(FromUnstructured, ShrunkCellsThatFitNotAreNamed)
{
  HexahedronExport shrunk;
  shrunk.scale = 0.75;
  const auto moved = makeHexahedra(nineCells(), shrunk);
  for (vtkIdType p = 0; p < 8; ++p)
  {
    std::array<double, 3> at;
    const vtkIdType id = moved->GetCell(6)->GetPointId(static_cast<int>(p));
    moved->GetPoint(id, at.data());
    at[1] += 0.125;
    moved->GetPoints()->SetPoint(id, at.data());
  }
  expectIn(errorOf(moved),
    "cell 6, which reaches from (0.0625, 0.6875, 0.5625) to (0.4375, 1.0625, 0.9375), fits no place of the "
    "lattice of the largest cells, which are (1, 1, 1) wide like that from (1.125, 0.125, 0.125)");
}

TEST(FromUnstructured, CellsOfOtherKindsAreNamed)
{
  const auto withCell = [](int type, std::vector<vtkIdType> ids) {
    const auto grid = makeHexahedra(nineCells(), {});
    vtkNew<vtkUnstructuredGrid> other;
    other->SetPoints(grid->GetPoints());
    other->Allocate(1);
    for (int i = 0; i < 4; ++i)
    {
      other->InsertNextCell(grid->GetCellType(i), grid->GetCell(i)->GetPointIds());
    }
    other->InsertNextCell(type, static_cast<vtkIdType>(ids.size()), ids.data());
    return vtkSmartPointer<vtkUnstructuredGrid>(other);
  };
  expectIn(errorOf(withCell(VTK_WEDGE, { 0, 1, 2, 4, 5, 6 })),
    "cell 4, a vtkWedge, which reaches from (0, 0, 0) to");
  expectIn(errorOf(withCell(VTK_TETRA, { 0, 1, 2, 4 })), "cell 4, a vtkTetra, ");
  expectIn(errorOf(withCell(VTK_QUAD, { 0, 1, 2, 3 })), "cell 4, a vtkQuad of 2 dimensions, ");
  expectIn(errorOf(withCell(VTK_HEXAHEDRON, { 0, 1, 2, 3, 4, 5, 6, 99999 })),
    "cell 4, a hexahedron whose points are not eight of the 72 there are");
  expectIn(errorOf(withCell(VTK_HEXAHEDRON, { 0, 1, 2, 3, 4, 5, 6 })), "cell 4, a hexahedron whose points");

  vtkNew<vtkUnstructuredGrid> square;
  vtkNew<vtkPoints> points;
  for (int p = 0; p < 4; ++p)
  {
    points->InsertNextPoint(p % 2, p / 2, 0.);
  }
  square->SetPoints(points);
  const vtkIdType pixel[] = { 0, 1, 2, 3 };
  square->Allocate(1);
  square->InsertNextCell(VTK_PIXEL, 4, pixel);
  expectIn(errorOf(square),
    "cell 0, a vtkPixel of 2 dimensions, which reaches from (0, 0, 0) to (1, 1, 0); allowed");
}

TEST(FromUnstructured, ArraysAndLatticesThatFitNotAreNamed)
{
  const auto shortArray = makeHexahedra(nineCells(), {});
  shortArray->GetCellData()->GetArray("number")->SetNumberOfTuples(8);
  expectIn(errorOf(shortArray), "cell array 'number' has 8 tuples, allowed are 9");

  expectIn(errorOf(makeHexahedra({ { { 0, 0, 0 }, 0 }, { { Coord(1) << 21, 0, 0 }, 0 } }, {})),
    "allowed are 1048576");
  // Each axis has room for them, VTK's numbers of roots have not.
  expectIn(errorOf(makeHexahedra({ { { 0, 0, 0 }, 0 }, { { 90000, 70001, 3 }, 0 } }, {})),
    "a lattice of 90001 x 70002 x 4 trees, allowed 4294967295 places");
}

// Of several pieces in one process.
TEST(FromUnstructured, OtherPiecesAreEmpty)
{
  vtkNew<vtkTrivialProducer> source; // gives all to whoever asks
  const auto input = makeHexahedra(nineCells(), {});
  source->SetOutput(input);
  vtkNew<vtkTreeAMRFromUnstructured> filter;
  filter->SetInputConnection(source->GetOutputPort());
  filter->UpdatePiece(1, 2, 0);
  EXPECT_EQ(vtkHyperTreeGrid::SafeDownCast(filter->GetOutputDataObject(0))->GetNumberOfNonEmptyTrees(), 0);
  filter->UpdatePiece(0, 2, 0);
  EXPECT_EQ(vtkHyperTreeGrid::SafeDownCast(filter->GetOutputDataObject(0))->GetNumberOfLeaves(), 9);
}

// VTK counts masked cells: where no cell is the arrays have values of those beside it.
TEST(FromUnstructured, MissingCellsDoNotWidenRanges)
{
  std::vector<CellId> cells = nineCells();
  cells.erase(cells.begin() + 2, cells.begin() + 5);
  const auto input = makeHexahedra(cells, {});
  vtkDataArray* const numbers = input->GetCellData()->GetArray("number");
  vtkNew<vtkDoubleArray> far;
  far->SetName("far");
  vtkNew<vtkStringArray> texts;
  texts->SetName("texts");
  for (vtkIdType i = 0; i < input->GetNumberOfCells(); ++i)
  {
    numbers->SetTuple1(i, 7. + static_cast<double>(i));
    far->InsertNextValue(101325. + 0.125 * static_cast<double>(i));
    texts->InsertNextValue("cell");
  }
  input->GetCellData()->AddArray(far);
  input->GetCellData()->AddArray(texts);
  vtkNew<vtkTreeAMRFromUnstructured> filter;
  filter->SetInputData(input);
  filter->Update();
  vtkCellData* const data = vtkHyperTreeGrid::SafeDownCast(filter->GetOutputDataObject(0))->GetCellData();
  for (const char* name : { "number", "far" })
  {
    for (int i = 0; i < 2; ++i)
    {
      EXPECT_EQ(data->GetArray(name)->GetRange()[i], input->GetCellData()->GetArray(name)->GetRange()[i]);
    }
  }
  auto* const outTexts = vtkStringArray::SafeDownCast(data->GetAbstractArray("texts"));
  ASSERT_NE(outTexts, nullptr);
  for (vtkIdType i = 0; i < outTexts->GetNumberOfValues(); ++i)
  {
    EXPECT_EQ(outTexts->GetValue(i), "cell");
  }
}
