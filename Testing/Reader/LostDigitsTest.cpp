// What is said of values of which neither floats nor doubles hold all digits.
#include "LostDigits.h"
#include "OnceReporter.h"

#include "Support/HyperTreeGrids.h"

#include "vtkCellData.h"
#include "vtkDataArray.h"
#include "vtkDoubleArray.h"
#include "vtkFloatArray.h"
#include "vtkHyperTree.h"
#include "vtkHyperTreeGrid.h"
#include "vtkTypeInt64Array.h"
#include "vtkVariant.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <tuple>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

/// The remark on an array of value(i, component), or of whole(i), in the leaves 0 to 511; the vertices above have 0.
Remark remarkOn(vtkDataArray* array, const std::function<double(int, int)>& value, int component = 0,
  const std::function<vtkTypeInt64(int)>& whole = {})
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
    if (whole && tree->IsLeaf(v))
    {
      array->SetVariantValue(tree->GetGlobalIndexFromLocal(v), vtkVariant(whole(leaf)));
    }
    leaf += tree->IsLeaf(v);
  }
  grid->GetCellData()->AddArray(array);
  const ArraySelection selection{ "pressure", component };
  return unsuitableRange(*array, *acquireField(grid, selection));
}

Remark remarkOnDoubles(const std::function<double(int, int)>& value)
{
  vtkNew<vtkDoubleArray> array;
  return remarkOn(array, value);
}

} // namespace

TEST(LostDigits, RangesThatDoublesDoNotTellApart)
{
  const Remark first = remarkOnDoubles([](int i, int) { return 1e15 + i / 511.; });
  EXPECT_EQ(first.text,
    "hyper tree grid: the values of cell array 'pressure' differ by 1 at most, all around 1000000000000000; "
    "the "
    "numbers that isovalues, colours and results count in are 0.125 apart there: subtract a constant from "
    "the "
    "values, or multiply them if they are tiny");
  const Remark second = remarkOnDoubles([](int i, int) { return 2e15 + i / 511.; });
  EXPECT_NE(first.text, second.text);
  EXPECT_EQ(first.about, second.about);
  EXPECT_NE(remarkOnDoubles([](int i, int) { return -1e15 - i / 511.; }).text, "");
  EXPECT_NE(remarkOnDoubles([](int i, int) { return 3e-38 + 1e-43 * i; }).text, "");
  for (const auto& [bits, step, isSaid] : { std::tuple(52, 1, true), std::tuple(52, 1026, true),
         std::tuple(52, 1027, false), std::tuple(62, 1 << 21, false), std::tuple(62, 1, true) })
  {
    vtkNew<vtkTypeInt64Array> array;
    const std::string text = remarkOn(
      array, [](int, int) { return 0.; }, 0,
      [&](int i) {
        return (vtkTypeInt64(1) << bits) + i * vtkTypeInt64(step);
      }).text;
    EXPECT_EQ(!text.empty(), isSaid) << "2^" << bits << " and steps of " << step << ": " << text;
  }
}

TEST(LostDigits, ComponentsAndMagnitudes)
{
  const auto value = [](int i, int c) { return c == 1 ? 1e15 + i / 512. : i / 512.; };
  for (const auto& [component, isSaid] : { std::pair(0, false), std::pair(1, true), std::pair(-1, true) })
  {
    vtkNew<vtkDoubleArray> array;
    array->SetNumberOfComponents(2);
    EXPECT_NE(remarkOn(array, value, component).text.empty(), isSaid) << component;
  }
}

TEST(LostDigits, FiniteValuesThatFloatsHaveNot)
{
  const auto half = [](double large) {
    return remarkOnDoubles([large](int i, int) { return i % 2 ? large : i / 512.; }).text;
  };
  EXPECT_EQ(half(-1e39),
    "hyper tree grid: cell array 'pressure' has values from -1e+39 to 0.996094; allowed are those up to "
    "3.40282e+38, cells of others are missing: multiply them by a constant");
  EXPECT_NE(half(5e302), "");
  EXPECT_EQ(half(3e38), "");
  EXPECT_EQ(half(std::numeric_limits<double>::infinity()), "");
}

TEST(LostDigits, NothingIsSaidWhereNothingIsLost)
{
  const std::vector<std::pair<const char*, std::function<double(int, int)>>> cases{
    { "a constant", [](int, int) { return 0.1; } },
    { "zero", [](int i, int) { return i % 2 ? 0. : -0.; } },
    { "numbers that float has", [](int i, int) { return 1e9 + 64. * i; } },
    { "two far apart", [](int i, int) { return i % 2 ? 0.1 : 0.7; } },
    { "levels", [](int i, int) { return i % 5; } },
    { "within an offset's digits", [](int i, int) { return 101325. + i / 512e3; } },
    { "a large offset", [](int i, int) { return 1e9 + i / 512.; } },
  };
  for (const auto& [name, value] : cases)
  {
    EXPECT_EQ(remarkOnDoubles(value).text, "") << name;
  }
  vtkNew<vtkFloatArray> floats;
  EXPECT_EQ(remarkOn(floats, [](int i, int) { return 1e9 + i; }).text, "");
}

TEST(LostDigits, MessagesAreSaidOnceUntilTheyGoAway)
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
