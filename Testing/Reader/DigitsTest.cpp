// Values that lie close together beside their size, from cell arrays to all that is computed of them, against the same
// values less a constant, which floats hold without an offset.
#include "HyperTreeGridConverter.h"
#include "HyperTreeGridSource.h"
#include "vtkTreeAMRContourFilter.h"
#include "vtkTreeAMRProbeFilter.h"

#include "Contour/Contour.h"
#include "Interpolation/Sampler.h"
#include "Octree/TreePath.h"
#include "Support/Cameras.h"
#include "Support/HyperTreeGrids.h"
#include "Support/OneFrame.h"
#include "Support/RandomTrees.h"
#include "Surface/Isosurface.h"

#include "vtkAOSDataArrayTemplate.h"
#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkDoubleArray.h"
#include "vtkFloatArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkIntArray.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkPolyData.h"
#include "vtkSOADataArrayTemplate.h"
#include "vtkTypeInt64Array.h"
#include "vtkTypeUInt64Array.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <functional>
#include <limits>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

constexpr double bound = 0x1p-20; // of the range
constexpr int levels = 4;
constexpr int most = 448; // of g()

/// A linear field of whole numbers from 0 to `most`: index on the lattice of the finest cells' halves.
int g(const std::array<Coord, 3>& p)
{
  return static_cast<int>(p[0] + 2 * p[1] + 4 * p[2]);
}

/// Refined at random, with jumps of several levels.
vtkSmartPointer<vtkHyperTreeGrid> adaptiveGrid(double masked = 0.)
{
  return makeGrid({ .roots = { 2, 2, 2 }, .levels = levels, .masked = masked, .uniform = true });
}

/// Calls body(place of the value in arrays, g at the centre) for all leaves.
void forEachCell(vtkHyperTreeGrid* grid, const std::function<void(vtkIdType, int)>& body)
{
  const auto octree = acquireOctree(grid);
  TreePath path(*octree);
  forEachNode(path, [&](const TreePath& at) {
    if (at.node().isLeaf())
    {
      const int level = at.depth() - octree->grid().paddingDepth();
      std::array<Coord, 3> middle;
      for (int a = 0; a < 3; ++a)
      {
        middle[a] = (2 * at.index()[a] + 1) << (levels - level);
      }
      body(globalIndex(*grid, { at.index(), level }), g(middle));
    }
  });
}

struct Case
{
  const char* name;
  int type;
  long double constant;
  long double perStep; // of g()
  bool isMiddle;       // whether the constant is amid the values

  double range() const { return static_cast<double>(most * std::abs(perStep)); }
  long double less(long double step) const { return (isMiddle ? step - most / 2 : step) * perStep; }
};

const Case cases[]{
  { "101325 +- 0.001", VTK_DOUBLE, 101325.L, 0.002L / most, true },
  { "1e6 + 1e-3 z", VTK_DOUBLE, 1e6L, 1e-3L / most, false },
  { "1.7e9 + 100 z", VTK_DOUBLE, 1.7e9L, 100.L / most, false },
  { "near 2^52", VTK_TYPE_INT64, 0x1p52L, 4096.L, false },
  { "beyond 2^53", VTK_TYPE_INT64, -0x1p62L, 0x1p24L, false },
  { "up to 2^64 - 1", VTK_TYPE_UINT64, 0x1p64L - 1.L, -0x1p24L, false },
  { "ids of 32 bits", VTK_INT, 2e9L, 64.L, true },
};

/// The array "values" of a case and "less", the same as doubles less the constant.
class Pair
{
public:
  explicit Pair(const Case& c, vtkSmartPointer<vtkHyperTreeGrid> onGrid = adaptiveGrid())
    : grid(std::move(onGrid))
  {
    const vtkIdType count = countVertices(grid);
    auto values = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(c.type));
    vtkNew<vtkDoubleArray> less;
    values->SetName("values");
    less->SetName("less");
    values->SetNumberOfTuples(count);
    values->Fill(0.);
    less->SetNumberOfTuples(count);
    less->Fill(0.);
    forEachCell(grid, [&](vtkIdType i, int step) {
      const long double value = c.constant + c.less(step);
      switch (c.type)
      {
        vtkTemplateMacro(static_cast<VTK_TT*>(values->GetVoidPointer(0))[i] = static_cast<VTK_TT>(value));
      }
      less->SetValue(i,
        static_cast<double>(
          c.type == VTK_DOUBLE ? static_cast<double>(value) - c.constant : value - c.constant));
    });
    grid->GetCellData()->AddArray(values);
    grid->GetCellData()->AddArray(less);
    field = acquireField(grid, { "values" });
    twin = acquireField(grid, { "less" });
    shift = static_cast<double>(field->offset() - c.constant);
  }

  vtkSmartPointer<vtkHyperTreeGrid> grid;
  std::shared_ptr<const Field> field;
  std::shared_ptr<const Field> twin;
  double shift; // a twin's value less the same field's, as it is stored
};

vtkSmartPointer<vtkPolyData> randomPoints(vtkHyperTreeGrid* grid, int count)
{
  std::array<double, 6> bounds;
  computeLocalBounds(grid, bounds.data());
  return test::randomPoints(bounds, count);
}

Camera view(const Octree& octree, int width = 60, int height = 50)
{
  const Bounds box = octree.grid().bounds();
  const double size = box.max[0] - box.min[0];
  const Vec3 middle{ (box.min[0] + box.max[0]) / 2., (box.min[1] + box.max[1]) / 2.,
    (box.min[2] + box.max[2]) / 2. };
  return Camera(multiply(perspective(40., 0.1 * size, 20. * size),
                  lookAt({ middle[0] + 1.5 * size, middle[1] + size, middle[2] + 1.2 * size }, middle)),
    identityMatrix, width, height);
}

/// Colours and opacity from least to greatest of a case's values, less a number.
TransferFunction ramp(const Case& c, double less)
{
  std::vector<TransferFunction::Entry> entries;
  constexpr int last = 1 << 16; // fine enough to read the nearest one
  for (int i = 0; i <= last; ++i)
  {
    const float u = static_cast<float>(i) / last;
    entries.push_back({ u, 1.f - u, 0.5f, 2.f * u });
  }
  const auto first = static_cast<double>(c.less(0));
  const double least = std::min(first, static_cast<double>(c.less(most)));
  return TransferFunction(least - less, least + c.range() - less, entries);
}

/// The array's number at a point or cell.
long double number(vtkDataArray* array, vtkIdType i)
{
  long double value = 0.;
  switch (array->GetDataType())
  {
    vtkTemplateMacro(value = static_cast<long double>(static_cast<VTK_TT*>(array->GetVoidPointer(0))[i]));
  }
  return value;
}

/// Of whole numbers more than 2^24 apart it is said that they are rounded, of others nothing.
void expectWarnings(const Case& c, const MessageCatcher& warnings)
{
  const bool isRounded = c.type != VTK_DOUBLE && c.range() > 0x1p24;
  ASSERT_EQ(warnings.messages().size(), isRounded ? 1u : 0u) << c.name;
  if (isRounded)
  {
    EXPECT_NE(
      warnings.messages()[0].find("'values' has whole numbers that differ by up to"), std::string::npos)
      << warnings.messages()[0];
  }
}

} // namespace

TEST(Digits, LeavesKeepTheirs)
{
  for (const Case& c : cases)
  {
    const Pair p(c);
    EXPECT_NE(p.field->offset(), 0.) << c.name;
    EXPECT_EQ(p.twin->offset(), 0.) << c.name;
    const auto leaves = p.field->octree().leafCount();
    ASSERT_GT(leaves, 1000u);
    for (std::uint64_t i = 0; i < leaves; ++i)
    {
      const long double rest = p.field->leafValues()[i] + static_cast<long double>(p.shift);
      ASSERT_NEAR(rest, p.twin->leafValues()[i], 0x1p-23 * c.range()) << c.name << ", leaf " << i;
    }
  }
}

TEST(Digits, ProbesAnswerInTheArraysOwnType)
{
  for (const Case& c : cases)
  {
    const Pair p(c);
    const auto points = randomPoints(p.grid, 2000);
    vtkNew<vtkTreeAMRProbeFilter> probe;
    probe->SetInputData(points);
    probe->SetSourceData(p.grid);
    const MessageCatcher warnings(probe, vtkCommand::WarningEvent);
    for (int method = vtkTreeAMRProbeFilter::NEAREST; method <= vtkTreeAMRProbeFilter::GTI; ++method)
    {
      probe->SetInterpolationMethod(method);
      probe->Update();
      vtkPointData* output = probe->GetOutput()->GetPointData();
      vtkDataArray* values = output->GetArray("values");
      ASSERT_EQ(values->GetDataType(), c.type) << c.name;
      const bool isReal = c.type == VTK_DOUBLE;
      for (vtkIdType i = 0; i < points->GetNumberOfPoints(); ++i)
      {
        const long double expected = c.constant + output->GetArray("less")->GetTuple1(i);
        ASSERT_LE(std::abs(number(values, i) - expected), bound * c.range() + (isReal ? 0. : 0.5))
          << c.name << " by method " << method;
      }
    }
    expectWarnings(c, warnings);
  }
}

/// GTI has linear fields exactly, away from the boundary of the domain.
TEST(Digits, ALinearFieldIsWhatItIs)
{
  for (const Case& c : cases)
  {
    const Pair p(c);
    const Bounds box = p.field->octree().grid().bounds();
    const auto sampler = Sampler::create(InterpolationMethod::GTI, p.field);
    const auto points = randomPoints(p.grid, 2000);
    int compared = 0;
    for (vtkIdType i = 0; i < points->GetNumberOfPoints(); ++i)
    {
      Vec3 at;
      points->GetPoint(i, at.data());
      Vec3 halves; // on g()'s lattice
      bool isInner = true;
      for (int a = 0; a < 3; ++a)
      {
        halves[a] = (at[a] - box.min[a]) / (box.max[a] - box.min[a]) * 64.;
        isInner = isInner && halves[a] > 24. && halves[a] < 40.;
      }
      if (!isInner)
      {
        continue;
      }
      ++compared;
      const double step = halves[0] + 2. * halves[1] + 4. * halves[2];
      FieldSample sample;
      ASSERT_TRUE(sampler->sampleRelative(at, sample));
      const double expected =
        (c.isMiddle ? step - most / 2 : step) * static_cast<double>(c.perStep) - p.shift;
      ASSERT_NEAR(sample.value, expected, bound * c.range()) << c.name;
      FieldSample whole;
      ASSERT_TRUE(sampler->sample(at, whole));
      ASSERT_EQ(whole.value, sample.value + p.field->offset());
    }
    EXPECT_GT(compared, 20);
  }
}

TEST(Digits, ContoursAndWhatColoursThem)
{
  for (const Case& c : cases)
  {
    const Pair p(c);
    const auto isovalue = static_cast<double>(c.constant + c.less(268.37L));
    const auto lessOne = static_cast<double>(isovalue - c.constant);
    const auto contourOf = [&](const char* name, double value) {
      vtkNew<vtkTreeAMRContourFilter> filter;
      filter->SetInputData(p.grid);
      filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, name);
      filter->SetValue(0, value);
      const MessageCatcher warnings(filter, vtkCommand::WarningEvent);
      filter->Update();
      if (std::string(name) == "less")
      {
        expectWarnings(c, warnings); // of the other array
      }
      return vtkSmartPointer<vtkPolyData>(filter->GetOutput());
    };
    const auto mesh = contourOf("values", isovalue);
    const auto expected = contourOf("less", lessOne);
    ASSERT_GT(expected->GetNumberOfPoints(), 300);
    ASSERT_EQ(mesh->GetNumberOfPoints(), expected->GetNumberOfPoints()) << c.name;
    ASSERT_EQ(mesh->GetNumberOfPolys(), expected->GetNumberOfPolys()) << c.name;
    const auto sampler = Sampler::create(InterpolationMethod::GTI, p.twin);
    vtkDataArray* scalars = mesh->GetPointData()->GetScalars();
    vtkDataArray* others = expected->GetPointData()->GetArray("values");
    EXPECT_EQ(scalars->GetDataType(), VTK_DOUBLE);
    EXPECT_EQ(others->GetDataType(), VTK_DOUBLE);
    const double rounding = std::abs(std::nextafter(isovalue, 1.) - isovalue); // of doubles
    for (vtkIdType i = 0; i < mesh->GetNumberOfPoints(); ++i)
    {
      std::array<double, 3> at;
      mesh->GetPoint(i, at.data());
      FieldSample sample;
      ASSERT_TRUE(sampler->sample(at, sample));
      ASSERT_NEAR(sample.value, lessOne, bound * c.range()) << c.name;
      ASSERT_EQ(scalars->GetTuple1(i), isovalue);
      ASSERT_NEAR(others->GetTuple1(i), isovalue, bound * c.range() + rounding) << c.name;
    }
  }
}

TEST(Digits, IsosurfacesAreWhereTheyAre)
{
  for (const Case& c : cases)
  {
    const Pair p(c);
    const std::vector<double> isovalues{ static_cast<double>(c.constant + c.less(111.61L)),
      static_cast<double>(c.constant + c.less(268.37L)) };
    std::vector<double> lessOnes;
    for (const double isovalue : isovalues)
    {
      lessOnes.push_back(static_cast<double>(isovalue - c.constant));
    }
    const Isosurface surface(p.field, isovalues);
    std::vector<double> ascending = isovalues;
    std::sort(ascending.begin(), ascending.end());
    EXPECT_EQ(surface.isovalues(), ascending) << c.name;
    const Isosurface expected(p.twin, lessOnes);
    const Camera camera = view(p.field->octree());
    HitImage hits;
    HitImage expectedHits;
    surface.render(camera, SurfaceLayers::All, hits);
    expected.render(camera, SurfaceLayers::All, expectedHits);
    ASSERT_EQ(hits.first, expectedHits.first) << c.name;
    ASSERT_GT(hits.hits.size(), 1000u);
    const Bounds box = p.field->octree().grid().bounds();
    for (std::size_t i = 0; i < hits.hits.size(); ++i)
    {
      ASSERT_EQ(hits.hits[i].surface, expectedHits.hits[i].surface);
      ASSERT_NEAR(hits.hits[i].t, expectedHits.hits[i].t, bound * 4. * (box.max[0] - box.min[0])) << c.name;
    }
  }
}

TEST(Digits, VolumesAreThatBrightThere)
{
  for (const Case& c : cases)
  {
    const Pair p(c);
    const Camera camera = view(p.field->octree());
    Image image(camera.width(), camera.height());
    Image expected = image;
    VolumeSettings settings;
    for (const double levelOfDetail : { 0., 20. })
    {
      settings.levelOfDetailPixels = levelOfDetail;
      // Kept values are rounded to parts of a block's range.
      volumeOf(*p.field, ramp(c, p.shift), 0).render(camera, settings, image);
      volumeOf(*p.twin, ramp(c, 0.), 0).render(camera, settings, expected);
      float brightest = 0.f;
      for (std::size_t i = 0; i < image.rgba.size(); ++i)
      {
        brightest = std::max(brightest, expected.rgba[i]);
        ASSERT_NEAR(image.rgba[i], expected.rgba[i], 4e-6) << c.name << ", number " << i;
      }
      EXPECT_GT(brightest, 0.8f) << c.name;
    }
  }
}

TEST(Digits, WhatFloatHoldsIsStoredAsItIs)
{
  const auto grid = adaptiveGrid();
  const vtkIdType count = countVertices(grid);
  struct Kept
  {
    const char* name;
    vtkSmartPointer<vtkDataArray> array;
    std::function<double(int)> value;
  };
  const Kept all[]{
    { "-0", vtkSmartPointer<vtkDoubleArray>::New(), [](int) { return -0.; } },
    { "zeros", vtkSmartPointer<vtkDoubleArray>::New(), [](int i) { return i % 2 ? 0. : -0.; } },
    { "one value", vtkSmartPointer<vtkDoubleArray>::New(), [](int) { return 101325.; } },
    { "2^-15.9", vtkSmartPointer<vtkDoubleArray>::New(), [](int i) { return 1. + 0.0075 * i / most; } },
    { "about 0", vtkSmartPointer<vtkDoubleArray>::New(), [](int i) { return 1e-30 * (i - 100.3); } },
    { "far out", vtkSmartPointer<vtkDoubleArray>::New(), [](int i) { return i > 300 ? 1e30 : 101325.1; } },
    { "whole", vtkSmartPointer<vtkIntArray>::New(), [](int i) { return i; } },
    { "many", vtkSmartPointer<vtkTypeInt64Array>::New(), [](int i) { return 1e15 * i; } },
    { "floats", vtkSmartPointer<vtkFloatArray>::New(), [](int i) { return 1e9 + 64. * i; } },
  };
  for (const Kept& kept : all)
  {
    kept.array->SetName(kept.name);
    kept.array->SetNumberOfTuples(count);
    kept.array->Fill(0.);
    forEachCell(grid, [&](vtkIdType i, int step) { kept.array->SetTuple1(i, kept.value(step)); });
    grid->GetCellData()->AddArray(kept.array);
    const auto field = acquireField(grid, { kept.name });
    EXPECT_EQ(field->offset(), 0.) << kept.name;
    const HyperTreeGridTopology topology(grid);
    const CellValues values(*grid, { kept.name }, topology.globalIndexEnd());
    const LargeVector<float> expected =
      gatherLeafValues(field->octree(), HyperTreeGridSource<CellValues>(topology, values));
    const auto sampler = Sampler::create(InterpolationMethod::Nearest, field);
    for (std::size_t i = 0; i < expected.size(); ++i)
    {
      ASSERT_EQ(
        std::bit_cast<std::uint32_t>(field->leafValues()[i]), std::bit_cast<std::uint32_t>(expected[i]))
        << kept.name;
      const double value = field->value({ NodeKind::Leaf, 0, i });
      ASSERT_EQ(std::bit_cast<std::uint64_t>(value), std::bit_cast<std::uint64_t>(double(expected[i])))
        << kept.name;
    }
  }
}

TEST(Digits, OfWhatIsDrawnAlone)
{
  const Case& pressure = cases[0];
  const auto withLeftOut = [&](vtkSmartPointer<vtkHyperTreeGrid> grid, double leftOut) {
    Pair p(pressure, grid);
    vtkDataArray* values = grid->GetCellData()->GetArray("values");
    forEachCell(grid, [&](vtkIdType i, int step) {
      if (step % 7 == 0)
      {
        values->SetTuple1(i, leftOut);
      }
    });
    values->Modified();
    return acquireField(grid, { "values" });
  };
  for (const double leftOut : { std::nan(""), std::numeric_limits<double>::infinity(),
         -std::numeric_limits<double>::infinity(), 1e300 })
  {
    const auto field = withLeftOut(adaptiveGrid(0.1), leftOut);
    EXPECT_NEAR(field->offset(), 101325., 0.002) << leftOut;
    EXPECT_LE(field->range().max - field->range().min, pressure.range());
  }
  // Drawn, it is of the range.
  EXPECT_EQ(withLeftOut(adaptiveGrid(), 1e30)->offset(), 0.);
  // Masked or hidden it is not: forEachCell() knows what is drawn.
  const auto masked = adaptiveGrid(0.2);
  Pair p(pressure, masked);
  vtkDataArray* values = masked->GetCellData()->GetArray("values");
  std::vector<bool> drawn(countVertices(masked));
  forEachCell(masked, [&](vtkIdType i, int) { drawn[i] = true; });
  for (vtkIdType i = 0; i < countVertices(masked); ++i)
  {
    if (!drawn[i])
    {
      values->SetTuple1(i, i % 2 ? 1e30 : -1e30);
    }
  }
  values->Modified();
  EXPECT_EQ(acquireField(masked, { "values" })->offset(), p.field->offset());
}

TEST(Digits, OneValue)
{
  const auto probed = [](vtkDataArray* array, vtkHyperTreeGrid* grid) {
    array->SetName("constant");
    grid->GetCellData()->AddArray(array);
    vtkNew<vtkTreeAMRProbeFilter> probe;
    probe->SetInputData(randomPoints(grid, 20));
    probe->SetSourceData(grid);
    const MessageCatcher warnings(probe, vtkCommand::WarningEvent);
    probe->Update();
    return vtkSmartPointer<vtkDataArray>(probe->GetOutput()->GetPointData()->GetArray("constant"));
  };
  for (const double value : { 0.1, 101325.001, -1e-30, 3e38, 5. })
  {
    const auto grid = adaptiveGrid();
    vtkNew<vtkDoubleArray> array;
    array->SetNumberOfValues(countVertices(grid));
    array->FillValue(value);
    EXPECT_EQ(probed(array, grid)->GetTuple1(13), value);
    EXPECT_EQ(acquireField(grid, { "constant" })->offset(), value == 5. ? 0. : value);
  }
  for (const vtkTypeInt64 value : { std::numeric_limits<vtkTypeInt64>::max(),
         std::numeric_limits<vtkTypeInt64>::min(), (vtkTypeInt64(1) << 60) + 1, vtkTypeInt64(7) })
  {
    const auto grid = adaptiveGrid();
    vtkNew<vtkTypeInt64Array> array;
    array->SetNumberOfValues(countVertices(grid));
    array->FillValue(value);
    EXPECT_EQ(vtkAOSDataArrayTemplate<vtkTypeInt64>::FastDownCast(probed(array, grid))->GetValue(13), value);
  }
  const auto grid = adaptiveGrid();
  vtkNew<vtkTypeUInt64Array> array;
  array->SetNumberOfValues(countVertices(grid));
  array->FillValue(std::numeric_limits<vtkTypeUInt64>::max());
  EXPECT_EQ(vtkAOSDataArrayTemplate<vtkTypeUInt64>::FastDownCast(probed(array, grid))->GetValue(13),
    std::numeric_limits<vtkTypeUInt64>::max());
}

/// What doubles do not tell apart, in both of VTK's layouts of memory.
TEST(Digits, WholeNumbersToTheLast)
{
  const auto grid = adaptiveGrid();
  const vtkIdType count = countVertices(grid);
  vtkNew<vtkSOADataArrayTemplate<vtkTypeInt64>> columns;
  columns->SetName("columns");
  columns->SetNumberOfComponents(2);
  columns->SetNumberOfTuples(count);
  vtkNew<vtkTypeInt64Array> rows;
  rows->SetName("rows");
  rows->SetNumberOfValues(count);
  constexpr vtkTypeInt64 large = (vtkTypeInt64(1) << 60) + 129;
  for (vtkIdType i = 0; i < count; ++i)
  {
    columns->SetTypedComponent(i, 0, 0);
    columns->SetTypedComponent(i, 1, large);
    rows->SetValue(i, large);
  }
  forEachCell(grid, [&](vtkIdType i, int step) {
    columns->SetTypedComponent(i, 1, large + step);
    rows->SetValue(i, large + step);
  });
  grid->GetCellData()->AddArray(columns);
  grid->GetCellData()->AddArray(rows);
  const auto byRows = acquireField(grid, { "rows" });
  const auto byColumns = acquireField(grid, { "columns", 1 });
  EXPECT_EQ(byRows->offset(), byColumns->offset());
  EXPECT_EQ(byRows->leafValues(), byColumns->leafValues());
  TreePath path(byRows->octree());
  forEachNode(path, [&](const TreePath& at) {
    if (at.node().isLeaf())
    {
      const int level = at.depth() - byRows->octree().grid().paddingDepth();
      const vtkIdType i = globalIndex(*grid, { at.index(), level });
      ASSERT_EQ(
        static_cast<vtkTypeInt64>(byRows->offset()) + static_cast<vtkTypeInt64>(byRows->relative(at.node())),
        rows->GetValue(i));
    }
  });
  // Of a change that doubles do not see, too.
  columns->SetTypedComponent(0, 1, large - 1000);
  forEachCell(grid, [&](vtkIdType i, int step) { columns->SetTypedComponent(i, 1, large + step + 1); });
  columns->Modified();
  EXPECT_NE(acquireField(grid, { "columns", 1 }), byColumns);
}

TEST(Digits, MagnitudesAndCellsAtTheDepthLimit)
{
  const auto grid = adaptiveGrid();
  const vtkIdType count = countVertices(grid);
  vtkNew<vtkDoubleArray> vector;
  vector->SetName("vector");
  vector->SetNumberOfComponents(2);
  vector->SetNumberOfTuples(count);
  vector->Fill(0.);
  forEachCell(grid, [&](vtkIdType i, int step) { vector->SetTuple2(i, 0., -1e6 - 1e-3 * step / most); });
  grid->GetCellData()->AddArray(vector);
  const Pair height(cases[1], adaptiveGrid());
  const auto magnitude = acquireField(grid, { "vector", -1 });
  EXPECT_EQ(magnitude->offset(), height.field->offset());
  EXPECT_EQ(magnitude->leafValues(), height.field->leafValues());

  const Pair limited(cases[4], adaptiveGrid());
  limited.grid->SetDepthLimiter(1);
  const auto field = acquireField(limited.grid, { "values" });
  const auto twin = acquireField(limited.grid, { "less" });
  ASSERT_GT(field->leafValues().size(), 20u);
  const auto shift = static_cast<double>(field->offset() - cases[4].constant);
  for (std::size_t i = 0; i < field->leafValues().size(); ++i)
  {
    EXPECT_NEAR(field->leafValues()[i] + shift, twin->leafValues()[i], 0x1p-23 * cases[4].range());
  }
}
