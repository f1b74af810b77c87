// What the writers of simulations have made, as grids. Of a forest that libp4est writes for ParaView and saves, the two are
// the same; deal.II's files have the values of the function that was interpolated.
#include "vtkTreeAMRFromUnstructured.h"
#include "vtkTreeAMRP4estReader.h"

#include "Field/CornerValues.h"
#include "HyperTreeGridConverter.h"
#include "Interpolation/Sampler.h"
#include "Support/ExampleForests.h"
#include "Support/ForestBytes.h"
#include "Support/HyperTreeGrids.h"

#include "vtkCellData.h"
#include "vtkCommand.h"
#include "vtkDataArray.h"
#include "vtkHyperTreeGrid.h"
#include "vtkNew.h"
#include "vtkXMLPUnstructuredGridReader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <tuple>
#include <utility>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

/// Bounds to a 4096th, so that those that are nearly equal are, in their order.
std::vector<DrawnCell> leaves(vtkHyperTreeGrid* grid, const std::string& array)
{
  std::vector<DrawnCell> cells = drawnCells(grid, array);
  double off = 0.;
  for (DrawnCell& cell : cells)
  {
    for (double& x : cell.bounds)
    {
      const double rounded = std::round(x * 4096.) / 4096.;
      off = std::max(off, std::abs(x - rounded));
      x = rounded;
    }
  }
  EXPECT_LT(off, 2e-6);
  std::ranges::sort(cells, {}, &DrawnCell::bounds);
  return cells;
}

} // namespace

TEST(HexahedraOfWriters, P8estVtkHasTheForest)
{
  const TemporaryFolder folder;
  for (ForestWriter forest :
    { ForestWriter::unitCube(), ForestWriter::brick({ 3, 2, 2 }), ForestWriter::named("twocubes") })
  {
    forest.refine([](const ForestQuadrant& q) { return q.level < 2; });
    refineAtRandom(forest, 5, 4);
    forest.setPayload(sizeof(double), [](const ForestQuadrant& q, std::byte* payload) {
      const double value = static_cast<double>(hashOf(q) % 1000000) / 7.;
      std::memcpy(payload, &value, sizeof(value));
    });
    std::vector<double> values;
    for (const ForestQuadrant& q : forest.quadrants())
    {
      std::memcpy(&values.emplace_back(), q.payload.data(), sizeof(double));
    }
    ASSERT_GT(values.size(), 1u);
    forest.save(folder.file("writers.p8est"));
    vtkNew<vtkTreeAMRP4estReader> saved;
    saved->SetFileName(folder.file("writers.p8est").c_str());
    saved->SetPayload("double value");
    saved->GenerateLevelOn();
    saved->Update();
    for (const double scale : { 0.95, 1. })
    {
      forest.saveVtk(folder.file("writers"), "value", values, scale);
      vtkNew<vtkXMLPUnstructuredGridReader> reader;
      reader->SetFileName(folder.file("writers.pvtu").c_str());
      vtkNew<vtkTreeAMRFromUnstructured> filter;
      filter->SetInputConnection(reader->GetOutputPort());
      const MessageCatcher errors(filter, vtkCommand::ErrorEvent);
      filter->Update();
      ASSERT_TRUE(errors.messages().empty()) << errors.messages()[0];
      auto* const grid = vtkHyperTreeGrid::SafeDownCast(filter->GetOutputDataObject(0));
      for (const char* name : { "value", "level", "treeid" })
      {
        const std::vector<DrawnCell> expected = leaves(saved->GetHyperTreeGridOutput(), name);
        const std::vector<DrawnCell> found = leaves(grid, name);
        ASSERT_EQ(found.size(), values.size());
        ASSERT_EQ(expected.size(), values.size());
        for (std::size_t i = 0; i < found.size(); ++i)
        {
          ASSERT_EQ(found[i].bounds, expected[i].bounds);
          ASSERT_EQ(found[i].value, static_cast<float>(expected[i].value));
        }
      }
      EXPECT_TRUE(grid->GetCellData()->HasArray("mpirank"));
    }
  }
}

// Trees in any orientation, which the forest's own file says and the hexahedra do not need to; no boxes.
TEST(HexahedraOfWriters, P8estVtkOfOtherConnectivities)
{
  const TemporaryFolder folder;
  for (const auto& [name, isOfBoxes] : { std::pair("twowrap", true), std::pair("periodic", true),
         std::pair("rotwrap", true), std::pair("rotcubes", false), std::pair("shell", false) })
  {
    SCOPED_TRACE(name);
    ForestWriter forest = ForestWriter::named(name);
    forest.refine([](const ForestQuadrant& q) { return q.level < 1; });
    refineAtRandom(forest, 4, 4);
    forest.setPayload(sizeof(double), [](const ForestQuadrant& q, std::byte* payload) {
      const double value = static_cast<double>(hashOf(q) % 1000000) / 7.;
      std::memcpy(payload, &value, sizeof(value));
    });
    const auto quadrants = forest.quadrants();
    std::vector<double> values;
    for (const ForestQuadrant& q : quadrants)
    {
      std::memcpy(&values.emplace_back(), q.payload.data(), sizeof(double));
    }
    forest.saveVtk(folder.file("others"), "value", values);
    vtkNew<vtkXMLPUnstructuredGridReader> reader;
    reader->SetFileName(folder.file("others.pvtu").c_str());
    vtkNew<vtkTreeAMRFromUnstructured> filter;
    filter->SetInputConnection(reader->GetOutputPort());
    const MessageCatcher errors(filter, vtkCommand::ErrorEvent);
    filter->Update();
    auto* const grid = vtkHyperTreeGrid::SafeDownCast(filter->GetOutputDataObject(0));
    if (!isOfBoxes)
    {
      ASSERT_EQ(errors.messages().size(), 1u);
      EXPECT_NE(errors.messages()[0].find(", which reaches from ("), std::string::npos)
        << errors.messages()[0];
      EXPECT_EQ(grid->GetNumberOfNonEmptyTrees(), 0);
      continue;
    }
    ASSERT_TRUE(errors.messages().empty()) << errors.messages()[0];
    const std::vector<DrawnCell> found = leaves(grid, "level");
    std::vector<DrawnCell> expected;
    for (const ForestQuadrant& q : quadrants)
    {
      const auto corners = forest.bounds(q);
      DrawnCell cell;
      cell.value = q.level;
      for (int a = 0; a < 3; ++a)
      {
        std::tie(cell.bounds[a], cell.bounds[a + 3]) = std::minmax(corners[0][a], corners[1][a]);
      }
      expected.push_back(cell);
    }
    std::ranges::sort(expected, {}, &DrawnCell::bounds);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i)
    {
      ASSERT_EQ(found[i].bounds, expected[i].bounds);
      ASSERT_EQ(found[i].value, expected[i].value);
    }
    // What the reader makes of the saved forest, whose trees it turns.
    forest.save(folder.file("others.p8est"));
    vtkNew<vtkTreeAMRP4estReader> saved;
    saved->SetFileName(folder.file("others.p8est").c_str());
    saved->SetPayload("double value");
    saved->Update();
    const std::vector<DrawnCell> read = leaves(saved->GetHyperTreeGridOutput(), "value");
    const std::vector<DrawnCell> written = leaves(grid, "value");
    ASSERT_EQ(read.size(), values.size());
    ASSERT_EQ(written.size(), values.size());
    for (std::size_t i = 0; i < read.size(); ++i)
    {
      ASSERT_EQ(written[i].bounds, read[i].bounds);
      ASSERT_EQ(written[i].value, static_cast<float>(read[i].value));
    }
  }
}

// Testing/Data/DealII/waves.cc says how the files were made: point data of a trilinear function, cells split into patches, two
// pieces. Between the corners of cells it is the function everywhere; levels were values of cells.
TEST(HexahedraOfWriters, DealIIHasPatches)
{
  struct Case
  {
    const char* name;
    vtkIdType cells;
    int patches;
    std::array<double, 3> rootSize;
    double volume;
  };
  for (const Case& c : { Case{ "cube", 288, 1, { 2., 2., 2. }, 8. },
         Case{ "rectangle", 34, 3, { 0.4, 0.35, 0.3 }, 1.2 * 0.7 * 0.3 },
         Case{ "hyper_L", 56, 2, { 1., 1., 1. }, 7. } })
  {
    SCOPED_TRACE(c.name);
    vtkNew<vtkXMLPUnstructuredGridReader> reader;
    reader->SetFileName((std::string(TREEAMR_DATA_DIR) + "/DealII/" + c.name + "_0.pvtu").c_str());
    vtkNew<vtkTreeAMRFromUnstructured> filter;
    filter->SetInputConnection(reader->GetOutputPort());
    const MessageCatcher errors(filter, vtkCommand::ErrorEvent);
    const MessageCatcher warnings(filter, vtkCommand::WarningEvent);
    filter->Update();
    ASSERT_TRUE(errors.messages().empty()) << errors.messages()[0];
    EXPECT_TRUE(warnings.messages().empty()) << warnings.messages()[0];
    auto* const grid = vtkHyperTreeGrid::SafeDownCast(filter->GetOutputDataObject(0));
    const std::vector<DrawnCell> levels = drawnCells(grid, "level");
    ASSERT_EQ(static_cast<vtkIdType>(levels.size()), c.cells * c.patches * c.patches * c.patches);
    const auto field = acquireField(grid, { "wave" });
    ASSERT_TRUE(field->corners());
    const auto sampler = Sampler::create(InterpolationMethod::GTI, field);
    const auto ofCells = Sampler::create(InterpolationMethod::Nearest, acquireField(grid, { "level" }));
    const double range = static_cast<double>(field->range().max) - field->range().min;
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(0.001, 0.999);
    for (int i = 0; i < 10000; ++i)
    {
      const DrawnCell& cell = levels[random() % levels.size()];
      std::array<double, 3> p;
      for (int a = 0; a < 3; ++a)
      {
        p[a] = std::lerp(cell.bounds[a], cell.bounds[a + 3], uniform(random));
      }
      FieldSample sample;
      ASSERT_TRUE(sampler->sample(p, sample));
      ASSERT_NEAR(sample.value, 0.5 + p[0] + 2. * p[1] - p[2] + 3. * p[0] * p[1] * p[2], 1e-6 * range);
      ASSERT_TRUE(ofCells->sample(p, sample));
      ASSERT_EQ(sample.value, cell.value);
    }
    double volume = 0.;
    for (const DrawnCell& leaf : levels)
    {
      double cell = 1.;
      for (int a = 0; a < 3; ++a)
      {
        const double width = leaf.bounds[a + 3] - leaf.bounds[a];
        cell *= width;
        EXPECT_NEAR(width, c.rootSize[a] / c.patches / std::exp2(leaf.value), 1e-6);
      }
      volume += cell;
    }
    EXPECT_NEAR(volume, c.volume, 1e-5);
  }
}
