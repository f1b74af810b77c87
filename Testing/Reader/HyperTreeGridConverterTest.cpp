// The converter against an independent walk with VTK's cursors, and what it refuses.
#include "HyperTreeGridConverter.h"

#include "Error.h"
#include "Support/HyperTreeGrids.h"

#include "vtkBitArray.h"
#include "vtkCellData.h"
#include "vtkDataSetAttributes.h"
#include "vtkDoubleArray.h"
#include "vtkHyperTree.h"
#include "vtkHyperTreeGrid.h"
#include "vtkHyperTreeGridNonOrientedGeometryCursor.h"
#include "vtkIntArray.h"
#include "vtkMath.h"
#include "vtkNew.h"
#include "vtkRandomHyperTreeGridSource.h"
#include "vtkStringArray.h"
#include "vtkUniformHyperTreeGrid.h"
#include "vtkUnsignedCharArray.h"
#include "vtkXMLHyperTreeGridReader.h"
#include "vtkXMLHyperTreeGridWriter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

/// Compares leaf by leaf and returns their number.
std::size_t expectSameLeaves(vtkHyperTreeGrid* grid, const std::string& array, int component = -1)
{
  const std::vector<DrawnCell> expected = drawnCells(grid, array, component);
  const std::vector<DrawnCell> found = drawnCells(*acquireField(grid, { array, component }));
  EXPECT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < std::min(found.size(), expected.size()); ++i)
  {
    EXPECT_EQ(found[i].bounds, expected[i].bounds) << "leaf " << i;
    EXPECT_FLOAT_EQ(static_cast<float>(found[i].value), static_cast<float>(expected[i].value))
      << "leaf " << i;
    EXPECT_EQ(found[i].ghost, expected[i].ghost) << "leaf " << i;
    if (testing::Test::HasFailure())
    {
      break;
    }
  }
  return expected.size();
}

std::string errorOf(vtkHyperTreeGrid* grid, const ArraySelection& selection = { "scalar" })
{
  try
  {
    acquireField(grid, selection);
  }
  catch (const Error& e)
  {
    return e.what();
  }
  return "no error";
}

void expectError(
  vtkHyperTreeGrid* grid, const std::string& part, const ArraySelection& selection = { "scalar" })
{
  const std::string message = errorOf(grid, selection);
  EXPECT_NE(message.find(part), std::string::npos) << message;
}

double lowerCorner(vtkHyperTreeGridNonOrientedGeometryCursor* cursor, int axis)
{
  return std::min(cursor->GetOrigin()[axis], cursor->GetOrigin()[axis] + cursor->GetSize()[axis]);
}

/// Compares the global indices of a vertex and of those below it, and returns their number.
int expectSameIndices(vtkHyperTreeGrid* grid, vtkHyperTreeGridNonOrientedGeometryCursor* cursor,
  const RootGrid& rootGrid, const CellId& cell)
{
  const Bounds bounds = rootGrid.nodeBounds(cell.index, rootGrid.paddingDepth() + cell.level);
  int mirrored = 0;
  for (int a = 0; a < 3; ++a)
  {
    EXPECT_EQ(bounds.min[a], lowerCorner(cursor, a));
    mirrored |= (cursor->GetSize()[a] < 0.) << a;
  }
  EXPECT_EQ(globalIndex(*grid, cell), cursor->GetGlobalNodeIndex());
  int compared = 1;
  for (int child = 0; !cursor->IsMasked() && !cursor->IsLeaf() && child < 8; ++child)
  {
    cursor->ToChild(static_cast<unsigned char>(child ^ mirrored));
    const CellId below{ { 2 * cell.index[0] + (child & 1), 2 * cell.index[1] + (child >> 1 & 1),
                          2 * cell.index[2] + (child >> 2) },
      cell.level + 1 };
    compared += expectSameIndices(grid, cursor, rootGrid, below);
    cursor->ToParent();
  }
  return compared;
}

vtkDoubleArray* scalarOf(vtkHyperTreeGrid* grid)
{
  return vtkDoubleArray::SafeDownCast(grid->GetCellData()->GetArray("scalar"));
}

} // namespace

// ---- leaf by leaf

struct GridCase
{
  const char* name;
  RandomHyperTreeGrid options;
};

void PrintTo(const GridCase& c, std::ostream* out)
{
  *out << c.name;
}

class ConvertedGrid : public testing::TestWithParam<GridCase>
{
};

TEST_P(ConvertedGrid, HasTheLeavesThatCursorsFind)
{
  RandomHyperTreeGrid options = GetParam().options;
  std::size_t leaves = 0;
  for (std::uint32_t seed = 1; seed <= 6; ++seed)
  {
    options.seed = seed;
    const auto grid = makeGrid(options);
    leaves += expectSameLeaves(grid, "scalar");
    leaves += expectSameLeaves(grid, "vector", 1);
    leaves += expectSameLeaves(grid, "vector"); // the magnitude
    leaves += expectSameLeaves(grid, "count", 0);
  }
  EXPECT_GT(leaves, 250u);
}

TEST_P(ConvertedGrid, KnowsTheGlobalIndicesOfCells)
{
  RandomHyperTreeGrid options = GetParam().options;
  int compared = 0;
  for (options.seed = 1; options.seed <= 6; ++options.seed)
  {
    const auto grid = makeGrid(options);
    const RootGrid rootGrid = acquireField(grid, { "scalar" })->octree().grid();
    vtkHyperTreeGrid::vtkHyperTreeGridIterator iterator;
    grid->InitializeTreeIterator(iterator);
    vtkNew<vtkHyperTreeGridNonOrientedGeometryCursor> cursor;
    vtkIdType id = 0;
    while (iterator.GetNextTree(id))
    {
      grid->InitializeNonOrientedGeometryCursor(cursor, id);
      CellId root;
      for (int a = 0; a < 3; ++a)
      {
        while (rootGrid.worldPlane(a, root.index[a], 0) < lowerCorner(cursor, a))
        {
          ++root.index[a];
        }
      }
      compared += expectSameIndices(grid, cursor, rootGrid, root);
    }
  }
  EXPECT_GT(compared, 50);
}

TEST(Converter, RefusesCellsThatTheGridHasNot)
{
  const auto grid = makeUniformlyRefinedGrid(1);
  EXPECT_EQ(globalIndex(*grid, { { 1, 0, 1 }, 1 }), 6);
  for (const CellId& cell : { CellId{ { 2, 0, 0 }, 1 }, CellId{ { 0, -1, 0 }, 0 }, CellId{ { 0, 0, 1 }, 2 } })
  {
    EXPECT_THROW(globalIndex(*grid, cell), Error);
  }
}

INSTANTIATE_TEST_SUITE_P(Random, ConvertedGrid,
  testing::Values(GridCase{ "Plain", {} }, GridCase{ "Transposed", { .transposedRoots = true } },
    GridCase{ "MissingTrees", { .roots = { 5, 1, 3 }, .missingTrees = 0.3 } },
    GridCase{
      "MissingTreesTransposed", { .roots = { 1, 4, 2 }, .missingTrees = 0.3, .transposedRoots = true } },
    GridCase{ "Masked", { .masked = 0.15 } },
    GridCase{ "Ghosts", { .levels = 6, .refine = 0.35, .ghosts = 0.2 } },
    GridCase{ "NotFinite", { .notFinite = 0.2 } }, GridCase{ "ExplicitIndices", { .explicitIndices = true } },
    GridCase{
      "MaskedGhostsNotFinite", { .masked = 0.1, .ghosts = 0.1, .notFinite = 0.1, .explicitIndices = true } },
    GridCase{ "Uniform", { .uniform = true } },
    GridCase{ "UniformMaskedLimited", { .masked = 0.1, .uniform = true, .depthLimit = 2 } },
    GridCase{ "MirroredX", { .mirrored = 1 } }, GridCase{ "MirroredY", { .mirrored = 2 } },
    GridCase{ "MirroredZ", { .mirrored = 4, .transposedRoots = true } },
    GridCase{ "MirroredXY", { .mirrored = 3, .explicitIndices = true } },
    GridCase{ "MirroredXZ", { .roots = { 5, 1, 3 }, .missingTrees = 0.3, .mirrored = 5 } },
    GridCase{ "MirroredYZ", { .masked = 0.15, .ghosts = 0.15, .mirrored = 6 } },
    GridCase{ "MirroredXYZUniform", { .masked = 0.1, .uniform = true, .mirrored = 7, .depthLimit = 2 } },
    GridCase{ "LimitedToRoots", { .depthLimit = 0 } }, GridCase{ "LimitedToOne", { .depthLimit = 1 } },
    GridCase{ "LimitBeyondTheTrees", { .depthLimit = 40 } },
    GridCase{ "Everything",
      { .missingTrees = 0.2,
        .masked = 0.15,
        .ghosts = 0.15,
        .notFinite = 0.15,
        .transposedRoots = true,
        .explicitIndices = true,
        .depthLimit = 3 } },
    GridCase{ "EverythingMirrored",
      { .missingTrees = 0.2,
        .masked = 0.15,
        .ghosts = 0.15,
        .notFinite = 0.15,
        .mirrored = 7,
        .transposedRoots = true,
        .explicitIndices = true,
        .depthLimit = 3 } }),
  [](const auto& info) { return info.param.name; });

TEST(Converter, TakesOneLargeTree)
{
  // Large enough to be cut up for several threads everywhere.
  const auto grid = makeGrid({ .seed = 3,
    .roots = { 1, 1, 1 },
    .levels = 6,
    .refine = 0.9,
    .masked = 0.01,
    .ghosts = 0.02,
    .notFinite = 0.02,
    .explicitIndices = true });
  ASSERT_GT(countVertices(grid), 100000);
  EXPECT_GT(expectSameLeaves(grid, "scalar"), 50000u);
  EXPECT_GT(expectSameLeaves(grid, "vector", 2), 50000u);
}

TEST(Converter, TakesAFewTreesOfAVastLattice)
{
  vtkNew<vtkUniformHyperTreeGrid> grid;
  grid->SetBranchFactor(2);
  grid->SetDimensions(301, 301, 301);
  grid->SetGridScale(1., 1., 1.);
  vtkNew<vtkDoubleArray> scalar;
  scalar->SetName("scalar");
  for (vtkIdType i = 0; i < 200; ++i)
  {
    vtkHyperTree* tree = grid->GetTree(i * 7919 * 17 % (300 * 300 * 300), true);
    tree->SetGlobalIndexStart(scalar->GetNumberOfValues());
    if (i % 3 == 0)
    {
      tree->SubdivideLeaf(0, 0);
    }
    for (vtkIdType v = 0; v < tree->GetNumberOfVertices(); ++v)
    {
      scalar->InsertNextValue(static_cast<double>(scalar->GetNumberOfValues()));
    }
  }
  grid->GetCellData()->AddArray(scalar);
  EXPECT_EQ(expectSameLeaves(grid, "scalar"), 133u + 67 * 8);
}

TEST(Converter, TakesVtksRandomGridsWithMasks)
{
  vtkNew<vtkRandomHyperTreeGridSource> source;
  source->SetDimensions(5, 5, 4);
  source->SetOutputBounds(0., 4., 0., 8., 0., 3.);
  source->SetMaxDepth(5);
  source->SetSplitFraction(0.4);
  for (vtkTypeUInt32 seed = 0; seed < 5; ++seed)
  {
    source->SetSeed(seed);
    source->Update();
    vtkHyperTreeGrid* grid = source->GetHyperTreeGridOutput();
    EXPECT_GT(expectSameLeaves(grid, "Depth"), 100u);
    addRandomMask(grid, 0.2, seed);
    EXPECT_GT(expectSameLeaves(grid, "Depth"), 10u);
  }
}

TEST(Converter, TakesGridsFromFiles)
{
  const std::string path = testing::TempDir() + "treeamr-converter-test.htg";
  for (const int version : { 1, 2 })
  {
    for (const RandomHyperTreeGrid& options : { RandomHyperTreeGrid{}, RandomHyperTreeGrid{ .masked = 0.15 },
           RandomHyperTreeGrid{ .roots = { 3, 1, 2 }, .missingTrees = 0.4, .transposedRoots = true } })
    {
      const auto grid = makeGrid(options);
      vtkNew<vtkXMLHyperTreeGridWriter> writer;
      writer->SetInputData(grid);
      writer->SetFileName(path.c_str());
      writer->SetDataSetMajorVersion(version);
      writer->SetDataModeToBinary(); // VTK 9.2 spoils version 2 with several arrays in its appended mode
      ASSERT_TRUE(writer->Write()) << "version " << version;
      vtkNew<vtkXMLHyperTreeGridReader> reader;
      reader->SetFileName(path.c_str());
      reader->Update();
      auto* read = vtkHyperTreeGrid::SafeDownCast(reader->GetOutputDataObject(0));
      ASSERT_NE(read, nullptr);
      EXPECT_EQ(expectSameLeaves(read, "scalar"), drawnCells(grid, "scalar").size());
      EXPECT_GT(expectSameLeaves(read, "vector", 2), 50u);
    }
  }
  std::remove(path.c_str());
}

TEST(Converter, ReadsEveryNumericType)
{
  const auto grid = makeGrid({});
  const vtkIdType count = grid->GetGlobalNodeIndexMax() + 1;
  for (const int type :
    { VTK_BIT, VTK_CHAR, VTK_SIGNED_CHAR, VTK_UNSIGNED_CHAR, VTK_SHORT, VTK_UNSIGNED_SHORT, VTK_INT,
      VTK_UNSIGNED_INT, VTK_LONG, VTK_UNSIGNED_LONG, VTK_LONG_LONG, VTK_ID_TYPE, VTK_FLOAT, VTK_DOUBLE })
  {
    const auto array = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(type));
    array->SetName("typed");
    array->SetNumberOfTuples(count);
    for (vtkIdType i = 0; i < count; ++i)
    {
      array->SetTuple1(i, type == VTK_BIT ? i % 2 : i % 100);
    }
    grid->GetCellData()->AddArray(array);
    EXPECT_GT(expectSameLeaves(grid, "typed"), 100u) << array->GetClassName();
  }
}

TEST(Converter, LeavesOutTheSubtreeOfAMaskedCoarseCell)
{
  const auto grid = makeUniformlyRefinedGrid(2);
  vtkHyperTree* tree = grid->GetTree(0);
  vtkNew<vtkBitArray> mask; // shorter than the cells: nothing beyond its end is masked
  const vtkIdType coarse = tree->GetElderChildIndex(0) + 3;
  mask->SetNumberOfTuples(coarse + 1);
  mask->Fill(0);
  mask->SetValue(coarse, 1);
  grid->SetMask(mask);
  const auto field = acquireField(grid, { "scalar" });
  EXPECT_EQ(field->octree().leafCount(), 56u);
  EXPECT_TRUE(field->octree().child(field->octree().root(), 3).isNone());
  EXPECT_FALSE(field->octree().child(field->octree().root(), 4).isNone());
}

TEST(Converter, TakesASingleCell)
{
  const auto grid = makeUniformlyRefinedGrid(0);
  const auto field = acquireField(grid, { "scalar" });
  EXPECT_EQ(field->octree().leafCount(), 1u);
  EXPECT_EQ(field->octree().innerCount(), 0u);
  EXPECT_EQ(field->leafValues(), treeamr::LargeVector<float>{ 1.f });
}

TEST(Converter, KeepsRootsThatCursorsPlaceFarApart)
{
  vtkNew<vtkHyperTreeGrid> grid;
  grid->SetBranchFactor(2);
  grid->SetDimensions(31, 21, 11);
  vtkNew<vtkDoubleArray> planes;
  for (int i = 0; i <= 30; ++i)
  {
    planes->InsertNextValue(i);
  }
  grid->SetXCoordinates(planes);
  grid->SetYCoordinates(planes);
  grid->SetZCoordinates(planes);
  vtkNew<vtkDoubleArray> scalar;
  scalar->SetName("scalar");
  for (const vtkIdType id : { vtkIdType(7), vtkIdType(30 * 20 * 10 - 1) })
  {
    grid->GetTree(id, true)->SetGlobalIndexStart(scalar->GetNumberOfValues());
    scalar->InsertNextValue(static_cast<double>(id));
  }
  grid->GetCellData()->AddArray(scalar);
  EXPECT_EQ(expectSameLeaves(grid, "scalar"), 2u);

  double bounds[6];
  computeLocalBounds(grid, bounds);
  const double expected[6] = { 7., 30., 0., 20., 0., 10. };
  EXPECT_TRUE(std::equal(bounds, bounds + 6, expected));
}

// ---- bounds

TEST(LocalBounds, AreThoseOfTheTreesHeld)
{
  for (const auto& [uniform, mirrored] : { std::pair(false, 0), { true, 0 }, { false, 5 }, { true, 2 } })
  {
    const auto grid = makeGrid({ .roots = { 4, 3, 2 }, .uniform = uniform, .mirrored = mirrored });
    const auto part = vtkSmartPointer<vtkHyperTreeGrid>::Take(grid->NewInstance());
    part->CopyEmptyStructure(grid);
    vtkIdType id = 0;
    grid->GetIndexFromLevelZeroCoordinates(id, 2, 1, 1);
    part->SetTree(id, grid->GetTree(id));
    double origin[3];
    double size[3];
    grid->GetLevelZeroOriginAndSizeFromIndex(id, origin, size);
    if (auto* u = vtkUniformHyperTreeGrid::SafeDownCast(part))
    {
      auto* from = vtkUniformHyperTreeGrid::SafeDownCast(grid);
      u->SetOrigin(from->GetOrigin());
      u->SetGridScale(from->GetGridScale());
    }
    double bounds[6];
    computeLocalBounds(part, bounds);
    for (int a = 0; a < 3; ++a)
    {
      EXPECT_DOUBLE_EQ(bounds[2 * a], std::min(origin[a], origin[a] + size[a]));
      EXPECT_DOUBLE_EQ(bounds[2 * a + 1], std::max(origin[a], origin[a] + size[a]));
    }
  }
}

TEST(LocalBounds, AreUninitialisedWithoutTrees)
{
  double bounds[6] = {};
  computeLocalBounds(nullptr, bounds);
  EXPECT_FALSE(vtkMath::AreBoundsInitialized(bounds));
  vtkNew<vtkHyperTreeGrid> grid;
  computeLocalBounds(grid, bounds);
  EXPECT_FALSE(vtkMath::AreBoundsInitialized(bounds));
  const auto empty = makeGrid({ .missingTrees = 1. });
  computeLocalBounds(empty, bounds);
  EXPECT_FALSE(vtkMath::AreBoundsInitialized(bounds));
}

// ---- what is not taken

TEST(ConverterError, NamesTheGridsKind)
{
  expectError(nullptr, "there is none");
  vtkNew<vtkHyperTreeGrid> empty;
  expectError(empty, "holds no tree");
  expectError(makeGrid({ .missingTrees = 1. }), "holds no tree");

  const auto box = makeUniformlyRefinedGrid(1);
  const auto withOneTree = [&](int planesAlongZ, unsigned int branchFactor) {
    const auto grid = vtkSmartPointer<vtkHyperTreeGrid>::New();
    grid->CopyEmptyStructure(box);
    grid->SetDimensions(2, 2, planesAlongZ);
    grid->SetBranchFactor(branchFactor);
    grid->GetTree(0, true)->SetGlobalIndexStart(0);
    return grid;
  };
  expectError(withOneTree(1, 2), "dimension is 2, allowed is 3");
  expectError(withOneTree(2, 3), "branch factor is 3, allowed is 2");

  const auto interfaces = makeGrid({});
  interfaces->SetHasInterface(true);
  expectError(interfaces, "material interfaces");
}

TEST(ConverterError, NamesBadCoordinates)
{
  const auto withX = [](std::vector<double> values) {
    const auto grid = makeGrid({}); // 3 planes along x
    vtkNew<vtkDoubleArray> planes;
    for (const double x : values)
    {
      planes->InsertNextValue(x);
    }
    grid->SetXCoordinates(planes);
    return grid;
  };
  expectError(withX({ 0., 1. }), "2 coordinates along x, its dimensions need 3");
  expectError(withX({ 0., 2., 1. }), "coordinate 2 along x");
  expectError(withX({ 0., 0., 1. }), "coordinate 1 along x");
  expectError(withX({ 0., std::nan(""), 1. }), "coordinate 1 along x");
  expectError(withX({ 0., 1., HUGE_VAL }), "coordinate 2 along x");
  const auto without = makeGrid({});
  without->SetYCoordinates(nullptr);
  expectError(without, "0 coordinates along y");
  expectError(withX({ 2., 0., 1. }), "coordinate 2 along x is 1 after 0");
  expectError(withX({ 2., 1., 1. }), "coordinate 2 along x");
  expectError(withX({ 2., 1., std::nan("") }), "coordinate 2 along x");
  const auto uniform = makeGrid({ .uniform = true });
  vtkUniformHyperTreeGrid::SafeDownCast(uniform)->SetGridScale(1., 0., 1.);
  expectError(uniform, "along y");
}

TEST(ConverterError, NamesTheArray)
{
  const auto grid = makeGrid({});
  expectError(grid, "'density' does not exist; there are: 'scalar', 'vector', 'count'; select one of them",
    { "density" });
  expectError(grid, "'' does not exist", { "" });
  expectError(grid, "'vector' has no component 3, allowed are 0 to 2", { "vector", 3 });

  vtkNew<vtkStringArray> names;
  names->SetName("names");
  names->SetNumberOfValues(scalarOf(grid)->GetNumberOfValues());
  grid->GetCellData()->AddArray(names);
  expectError(grid, "'names' is a vtkStringArray", { "names" });

  const vtkIdType count = scalarOf(grid)->GetNumberOfValues();
  scalarOf(grid)->SetNumberOfTuples(count - 1);
  expectError(
    grid, "'scalar' has " + std::to_string(count - 1) + " tuples, the cells need " + std::to_string(count));

  grid->GetCellData()->Initialize();
  expectError(
    grid, "there are: none; give the cells an array of numbers");
}

TEST(ConverterError, NamesDoublesBelowTheRangeOfFloat)
{
  const auto grid = makeGrid({});
  scalarOf(grid)->FillValue(-1e-45);
  expectError(grid, "the values of array 'scalar' are at most 1e-45; allowed are 1.17549e-38 and more");
  scalarOf(grid)->SetValue(0, 1.); // which single precision holds
  scalarOf(grid)->Modified();
  EXPECT_EQ(errorOf(grid), "no error");
  scalarOf(grid)->FillValue(0.);
  scalarOf(grid)->Modified();
  EXPECT_EQ(errorOf(grid), "no error");
}

TEST(ConverterError, SaysWhyNothingIsLeft)
{
  const auto masked = makeGrid({});
  addRandomMask(masked, 1., 1);
  expectError(masked, "all cells are masked or hidden");

  const auto hidden = makeGrid({});
  vtkNew<vtkUnsignedCharArray> ghosts;
  ghosts->SetName(vtkDataSetAttributes::GhostArrayName());
  ghosts->SetNumberOfValues(scalarOf(hidden)->GetNumberOfValues());
  ghosts->FillValue(vtkDataSetAttributes::HIDDENCELL);
  hidden->GetCellData()->AddArray(ghosts);
  expectError(hidden, "all cells are masked or hidden");
  ghosts->SetNumberOfValues(3);
  expectError(hidden, "'vtkGhostType' has 3 values");

  const auto nan = makeGrid({ .notFinite = 1. });
  expectError(nan, "no cell has a finite value in array 'scalar'");
  EXPECT_NO_THROW(acquireField(nan, { "vector" }));
  scalarOf(nan)->FillValue(1e60);
  expectError(nan, "within single precision, -3.40282e+38 to 3.40282e+38");
}

TEST(ConverterError, NamesBadTrees)
{
  const auto unnumbered = makeUniformlyRefinedGrid(1);
  vtkNew<vtkHyperTreeGrid> grid;
  grid->CopyEmptyStructure(unnumbered);
  grid->GetCellData()->AddArray(scalarOf(unnumbered));
  vtkHyperTree* tree = grid->GetTree(0, true);
  expectError(grid, "tree 0 has global indices for 0 of its 1 vertices");
  tree->SubdivideLeaf(0, 0);
  expectError(grid, "tree 0 has global indices for 0 of its 9 vertices");
  tree->SetGlobalIndexFromLocal(4, 4);
  expectError(grid, "tree 0 has global indices for 5 of its 9 vertices");

  const auto outside = makeUniformlyRefinedGrid(1);
  outside->SetTree(5, outside->GetTree(0));
  expectError(outside, "tree 5 is outside the lattice of 1 roots");
}

TEST(ConverterError, NamesTreesTooDeep)
{
  vtkNew<vtkHyperTreeGrid> grid;
  const auto box = makeUniformlyRefinedGrid(0);
  grid->CopyEmptyStructure(box);
  vtkHyperTree* tree = grid->GetTree(0, true);
  tree->SetGlobalIndexStart(0);
  vtkIdType vertex = 0;
  for (unsigned int level = 0; level < 70; ++level)
  {
    tree->SubdivideLeaf(vertex, level);
    vertex = tree->GetElderChildIndex(static_cast<unsigned int>(vertex)) + 7;
  }
  vtkNew<vtkDoubleArray> scalar;
  scalar->SetName("scalar");
  scalar->SetNumberOfValues(tree->GetNumberOfVertices());
  scalar->FillValue(1.);
  grid->GetCellData()->AddArray(scalar);
  expectError(grid, "deeper than level 60");
  grid->SetDepthLimiter(3); // the mean below goes as deep
  expectError(grid, "deeper than level 60");
  vtkNew<vtkBitArray> mask; // and so do marks
  mask->InsertNextValue(1);
  grid->SetMask(mask);
  expectError(grid, "deeper than level 60");
}
