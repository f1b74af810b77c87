// The converter's cache: what copies of a grid share, and that no change is overlooked.
#include "HyperTreeGridConverter.h"

#include "Support/HyperTreeGrids.h"

#include "vtkBitArray.h"
#include "vtkCellData.h"
#include "vtkDoubleArray.h"
#include "vtkHyperTree.h"
#include "vtkHyperTreeGrid.h"
#include "vtkNew.h"

#include <gtest/gtest.h>

#include <oneapi/tbb/parallel_for.h>

#include <set>
#include <thread>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

vtkSmartPointer<vtkHyperTreeGrid> shallowCopy(vtkHyperTreeGrid* grid)
{
  const auto copy = vtkSmartPointer<vtkHyperTreeGrid>::Take(grid->NewInstance());
  copy->ShallowCopy(grid);
  return copy;
}

vtkDoubleArray* scalarOf(vtkHyperTreeGrid* grid)
{
  return vtkDoubleArray::SafeDownCast(grid->GetCellData()->GetArray("scalar"));
}

} // namespace

TEST(FieldCache, SharesOctreeAndFieldBetweenCopies)
{
  for (const RandomHyperTreeGrid& options : { RandomHyperTreeGrid{},
         RandomHyperTreeGrid{ .masked = 0.1, .ghosts = 0.1, .notFinite = 0.1, .explicitIndices = true } })
  {
    const auto grid = makeGrid(options);
    const auto a = shallowCopy(grid);
    const auto b = shallowCopy(a);
    const auto fromA = acquireField(a, { "scalar" });
    EXPECT_EQ(acquireField(b, { "scalar" }), fromA);
    EXPECT_EQ(acquireField(b, { "scalar", 0 }), fromA); // the component of a scalar array
    const auto vector = acquireField(a, { "vector", 2 });
    const auto number = acquireField(b, { "count" });
    EXPECT_EQ(&number->octree(), &vector->octree());
    EXPECT_NE(acquireField(a, { "vector", 1 }), vector);
    EXPECT_NE(acquireField(a, { "vector" }), vector);
  }
}

TEST(FieldCache, SharesTheOctreeExceptForCutCells)
{
  const auto grid = makeGrid({ .notFinite = 0.2 });
  const auto scalar = acquireField(grid, { "scalar" });
  const auto vector = acquireField(grid, { "vector", 0 });
  EXPECT_LT(scalar->octree().leafCount(), vector->octree().leafCount());

  vtkNew<vtkDoubleArray> twin; // finite where "scalar" is
  twin->DeepCopy(scalarOf(grid));
  twin->SetName("twin");
  grid->GetCellData()->AddArray(twin);
  EXPECT_EQ(&acquireField(grid, { "twin" })->octree(), &scalar->octree());
}

TEST(FieldCache, KeepsNothingAlive)
{
  const auto grid = makeGrid({});
  std::weak_ptr<const Field> field;
  std::weak_ptr<const Octree> octree;
  {
    const auto held = acquireField(grid, { "scalar" });
    field = held;
    octree = held->sharedOctree();
  }
  EXPECT_TRUE(field.expired());
  EXPECT_TRUE(octree.expired());
}

TEST(FieldCache, SeesAnArrayChangedInPlace)
{
  const auto grid = makeGrid({});
  const auto copy = shallowCopy(grid);
  const auto before = acquireField(grid, { "scalar" });
  vtkDoubleArray* scalar = scalarOf(grid);
  for (vtkIdType i = 0; i < scalar->GetNumberOfValues(); ++i)
  {
    scalar->SetValue(i, 100. + static_cast<double>(i));
  }
  scalar->Modified();
  const auto after = acquireField(copy, { "scalar" });
  EXPECT_NE(after, before);
  EXPECT_EQ(&after->octree(), &before->octree());
  EXPECT_GE(after->range().min, 100.f);
  EXPECT_LE(before->range().max, 1.f);
}

// The grid is what data filters mark, the array stays as old as it was.
TEST(FieldCache, SeesValuesOfAnArrayThatIsNotMarked)
{
  const auto grid = makeGrid({});
  const auto before = acquireField(grid, { "scalar" });
  const auto beforeVector = acquireField(grid, { "vector", 2 });
  const vtkIdType leaf = scalarOf(grid)->GetNumberOfValues() - 1;
  scalarOf(grid)->SetValue(leaf, 12345.);
  grid->Modified();
  const auto after = acquireField(grid, { "scalar" });
  EXPECT_NE(after, before);
  EXPECT_EQ(after->range().max, 12345.f);
  EXPECT_EQ(acquireField(grid, { "vector", 2 }), beforeVector);
  scalarOf(grid)->SetValue(leaf, 54321.);
  EXPECT_EQ(acquireField(grid, { "scalar" })->range().max, 54321.f);
}

TEST(FieldCache, SeesTheTopologyChangedInPlace)
{
  const auto grid = makeUniformlyRefinedGrid(1);
  std::vector<std::shared_ptr<const Field>> held; // so that the entries of earlier states stay
  const auto leaves = [&] {
    return held.emplace_back(acquireField(grid, { "scalar" }))->octree().leafCount();
  };
  EXPECT_EQ(leaves(), 8u);
  vtkHyperTree* tree = grid->GetTree(0);
  const vtkIdType first = tree->GetElderChildIndex(0);
  tree->SubdivideLeaf(first + 5, 1);
  for (int i = 0; i < 8; ++i)
  {
    scalarOf(grid)->InsertNextValue(50.);
  }
  EXPECT_EQ(leaves(), 15u);

  vtkNew<vtkBitArray> mask;
  mask->SetNumberOfTuples(tree->GetNumberOfVertices());
  mask->Fill(0);
  mask->SetValue(first, 1);
  grid->SetMask(mask);
  EXPECT_EQ(leaves(), 14u);
  mask->SetValue(first + 1, 1); // without Modified()
  EXPECT_EQ(leaves(), 13u);
  grid->SetDepthLimiter(1);
  EXPECT_EQ(leaves(), 6u);
  grid->SetDepthLimiter(0);
  EXPECT_EQ(leaves(), 1u);
}

TEST(FieldCache, TellsTreesOfEqualSizeApart)
{
  const auto grid = makeUniformlyRefinedGrid(1);
  grid->GetTree(0)->SubdivideLeaf(1, 1);
  const auto other = makeUniformlyRefinedGrid(1);
  other->GetTree(0)->SubdivideLeaf(8, 1);
  scalarOf(grid)->SetNumberOfTuples(17);
  scalarOf(grid)->FillValue(1.);
  other->GetCellData()->ShallowCopy(grid->GetCellData());
  const auto field = acquireField(grid, { "scalar" });
  EXPECT_TRUE(field->octree().child(field->octree().root(), 0).isInner());
  const auto otherField = acquireField(other, { "scalar" });
  EXPECT_TRUE(otherField->octree().child(otherField->octree().root(), 7).isInner());
}

TEST(FieldCache, SeesTheCoordinatesChanged)
{
  const auto grid = makeUniformlyRefinedGrid(1);
  const auto before = acquireField(grid, { "scalar" });
  grid->GetYCoordinates()->SetTuple1(1, 2.); // one array is all three axes', so all change
  const auto after = acquireField(grid, { "scalar" });
  EXPECT_EQ(before->octree().grid().bounds().max[1], 1.);
  EXPECT_EQ(after->octree().grid().bounds().max[1], 2.);
}

TEST(FieldCache, TellsMirroredGridsApart)
{
  const auto grid = makeUniformlyRefinedGrid(1);
  vtkNew<vtkDoubleArray> turned;
  turned->InsertNextValue(1.);
  turned->InsertNextValue(0.);
  const auto mirrored = vtkSmartPointer<vtkHyperTreeGrid>::New();
  mirrored->ShallowCopy(grid);
  mirrored->SetXCoordinates(turned);
  const auto before = acquireField(grid, { "scalar" });
  const auto after = acquireField(mirrored, { "scalar" });
  EXPECT_EQ(after->octree().grid().bounds().max[0], 1.);
  for (int o = 0; o < 8; ++o)
  {
    const auto value = [o](const Field& f) { return f.value(f.octree().child(f.octree().root(), o)); };
    EXPECT_EQ(value(*before), 2. + o);
    EXPECT_EQ(value(*after), 2. + (o ^ 1));
  }
}

TEST(FieldCache, SeesTheMapOfIndicesChanged)
{
  const auto grid = makeUniformlyRefinedGrid(1);
  scalarOf(grid)->InsertNextValue(10.);
  const auto before = acquireField(grid, { "scalar" });
  grid->GetTree(0)->SetGlobalIndexStart(1);
  const auto after = acquireField(grid, { "scalar" });
  EXPECT_EQ(&after->octree(), &before->octree());
  EXPECT_EQ(before->range().min, 2.f);
  EXPECT_EQ(after->range().min, 3.f);

  const auto shuffled = makeGrid({ .levels = 2, .refine = 1., .explicitIndices = true });
  const auto original = acquireField(shuffled, { "scalar" });
  vtkHyperTree* tree = shuffled->GetTree(1);
  const vtkIdType leaf = tree->GetNumberOfVertices() - 1;
  scalarOf(shuffled)->SetValue(
    tree->GetGlobalIndexFromLocal(0), 77.); // of a coarse vertex, without Modified()
  tree->SetGlobalIndexFromLocal(leaf, tree->GetGlobalIndexFromLocal(0));
  EXPECT_LE(original->range().max, 1.f);
  EXPECT_EQ(acquireField(shuffled, { "scalar" })->range().max, 77.f);
}

TEST(FieldCache, IsNotFooledByANewArrayAtAnOldAddress)
{
  const auto grid = makeUniformlyRefinedGrid(1);
  std::set<vtkDataArray*> addresses;
  std::vector<std::shared_ptr<const Field>> held; // so that the entries stay
  for (int round = 0; round < 20; ++round)
  {
    grid->GetCellData()->Initialize();
    vtkNew<vtkDoubleArray> scalar;
    scalar->SetName("scalar");
    scalar->SetNumberOfValues(9);
    scalar->FillValue(round);
    grid->GetCellData()->AddArray(scalar);
    addresses.insert(scalar);
    held.push_back(acquireField(grid, { "scalar" }));
    EXPECT_EQ(held.back()->range().max, static_cast<float>(round));
  }
  if (addresses.size() == held.size())
  {
    GTEST_SKIP() << "no address came back (AddressSanitizer sees to that)";
  }
}

TEST(FieldCache, FieldsOfOneArrayShareTheirRanges)
{
  const auto grid = makeGrid({});
  const auto plain = acquireField(grid, { "scalar" });
  const std::size_t before = plain->byteSize();
  const NodeRanges& ranges = acquireField(grid, { "scalar" })->nodeRanges();
  EXPECT_EQ(&plain->nodeRanges(), &ranges);
  EXPECT_EQ(plain->byteSize(), before + ranges.byteSize());
  EXPECT_NE(&acquireField(grid, { "vector", 0 })->nodeRanges(), &ranges);
}

TEST(FieldCache, ServesManyThreadsWithOneField)
{
  const auto grid = makeGrid({ .roots = { 4, 4, 4 }, .masked = 0.05, .explicitIndices = true });
  std::vector<std::shared_ptr<const Field>> fields(8);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < fields.size(); ++i)
  {
    threads.emplace_back([&, i] { fields[i] = acquireField(grid, { "scalar" }); });
  }
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  for (const auto& field : fields)
  {
    EXPECT_EQ(field, fields[0]);
  }
}

TEST(FieldCache, CanBeCalledFromParallelTasks)
{
  std::vector<vtkSmartPointer<vtkHyperTreeGrid>> grids;
  for (std::uint32_t seed = 1; seed <= 8; ++seed)
  {
    grids.push_back(makeGrid({ .seed = seed, .roots = { 4, 4, 4 }, .levels = 4, .refine = 0.6 }));
  }
  std::vector<std::shared_ptr<const Field>> fields(64);
  tbb::parallel_for(std::size_t(0), fields.size(), [&](std::size_t i) {
    fields[i] = acquireField(grids[i / 4 % 8], { "vector", int(i % 4) - 1 });
  });
  for (std::size_t i = 0; i < fields.size(); ++i)
  {
    EXPECT_EQ(fields[i], fields[i % 32]);
    EXPECT_EQ(&fields[i]->octree(), &fields[i / 4 % 8 * 4]->octree());
  }
}
