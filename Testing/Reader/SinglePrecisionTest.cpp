// What is said of values that single precision does not tell apart, against counts of the values themselves.
#include "SinglePrecision.h"
#include "OnceReporter.h"

#include "Support/HyperTreeGrids.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkDoubleArray.h"
#include "vtkFloatArray.h"
#include "vtkHyperTree.h"
#include "vtkHyperTreeGrid.h"

#include <gtest/gtest.h>

#include <functional>
#include <set>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

/// The remark on an array of value(i, component) in the leaves 0 to 511; the vertices above have 0.
Remark remarkOn(vtkDataArray* array, const std::function<double(int, int)>& value, int component = 0)
{
  const auto grid = makeUniformlyRefinedGrid(3);
  const vtkIdType vertices = countVertices(grid);
  array->SetName("pressure");
  array->SetNumberOfTuples(vertices);
  array->Fill(0.);
  vtkHyperTree* tree = grid->GetTree(0);
  int leaf = 0;
  for (vtkIdType v = 0; v < tree->GetNumberOfVertices(); ++v)
  {
    for (int c = 0; tree->IsLeaf(v) && c < array->GetNumberOfComponents(); ++c)
    {
      array->SetComponent(tree->GetGlobalIndexFromLocal(v), c, value(leaf, c));
    }
    leaf += tree->IsLeaf(v);
  }
  grid->GetCellData()->AddArray(array);
  const ArraySelection selection{ "pressure", component };
  return mergedDoubles(grid, selection, *acquireField(grid, selection));
}

Remark remarkOnDoubles(const std::function<double(int, int)>& value)
{
  vtkNew<vtkDoubleArray> array;
  return remarkOn(array, value);
}

} // namespace

TEST(SinglePrecision, OffsetsWithoutDigitsLeft)
{
  for (const double offset : { 1e9, -1e9, 1e15, 1e5 })
  {
    const auto value = [&](int i, int) { return offset + i / 512.; };
    std::set<float> left;
    for (int i = 0; i < 512; ++i)
    {
      left.insert(static_cast<float>(value(i, 0)));
    }
    ASSERT_LT(left.size(), 512u);
    const std::string text = remarkOnDoubles(value).text;
    EXPECT_NE(text.find("'pressure'"), std::string::npos) << text;
    EXPECT_NE(text.find("single precision has " + std::to_string(left.size()) +
                (left.size() == 1 ? " number" : " different numbers") + " for them all"),
      std::string::npos)
      << text;
  }
  const Remark first = remarkOnDoubles([](int i, int) { return 1e9 + i / 512.; });
  EXPECT_NE(first.text.find("from 1000000000 to 1000000000.9980469;"), std::string::npos) << first.text;
  const Remark second = remarkOnDoubles([](int i, int) { return 2e9 + i / 512.; });
  EXPECT_NE(first.text, second.text);
  EXPECT_EQ(first.about, second.about);
}

TEST(SinglePrecision, ComponentsAndMagnitudes)
{
  const auto value = [](int i, int c) { return c == 1 ? 1e9 + i / 512. : i / 512.; };
  for (const auto& [component, isSaid] : { std::pair(0, false), std::pair(1, true), std::pair(-1, true) })
  {
    vtkNew<vtkDoubleArray> array;
    array->SetNumberOfComponents(2);
    EXPECT_NE(remarkOn(array, value, component).text.empty(), isSaid) << component;
  }
}

TEST(SinglePrecision, NothingIsSaidWhereNothingIsLost)
{
  const std::vector<std::pair<const char*, std::function<double(int, int)>>> cases{
    { "a constant", [](int, int) { return 0.1; } },
    { "zero", [](int i, int) { return i % 2 ? 0. : -0.; } },
    { "numbers that float has", [](int i, int) { return 1e9 + 64. * i; } },
    { "two far apart", [](int i, int) { return i % 2 ? 0.1 : 0.7; } },
    { "levels", [](int i, int) { return i % 5; } },
    { "more than 1024 steps", [](int i, int) { return 100. + i / 512.; } },
  };
  for (const auto& [name, value] : cases)
  {
    EXPECT_EQ(remarkOnDoubles(value).text, "") << name;
  }
  vtkNew<vtkFloatArray> floats;
  EXPECT_EQ(remarkOn(floats, [](int i, int) { return 1e9 + i; }).text, "");
}

TEST(SinglePrecision, MessagesAreSaidOnceUntilTheyGoAway)
{
  OnceReporter reporter;
  for (int round = 0; round < 3; ++round)
  {
    for (const char* message : { "a", "b" })
    {
      EXPECT_EQ(reporter.isNews(message), round == 0) << message << round;
      EXPECT_FALSE(reporter.isNews(message));
    }
    reporter.endRound();
  }
  EXPECT_FALSE(reporter.isNews("a"));
  reporter.endRound();
  EXPECT_FALSE(reporter.isNews("a"));
  EXPECT_TRUE(reporter.isNews("b"));
}
