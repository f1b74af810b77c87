#include "RefinedTrees.h"

#include "Support/RandomTrees.h"

#include <cmath>

namespace treeamr::report
{

Vec3 gradientOf(const AnalyticField& field, const Vec3& p)
{
  constexpr double step = 1e-6;
  Vec3 gradient;
  for (int a = 0; a < 3; ++a)
  {
    Vec3 low = p;
    Vec3 high = p;
    low[a] -= step;
    high[a] += step;
    gradient[a] = (field(high) - field(low)) / (high[a] - low[a]);
  }
  return gradient;
}

double BaseTree::finestWidth(int refinement) const
{
  return std::ldexp(1. / roots, -(levels + refinement));
}

std::vector<BaseTree> makeBaseTrees()
{
  constexpr std::array<int, 3> roots{ BaseTree::roots, BaseTree::roots, BaseTree::roots };
  const auto make = [&](const char* name, int levels, double refine, bool balanced) {
    return BaseTree{ name, test::makeRandomTree({ 11, roots, levels, refine, 0., balanced }), levels };
  };
  return { make("uniform", 1, 1., false), make("one-level", 3, 0.2, true),
    make("four-levels", 4, 0.25, false) };
}

std::shared_ptr<Field> makeField(const BaseTree& tree, int refinement, const AnalyticField& values)
{
  constexpr double rootWidth = 1. / BaseTree::roots;
  const Coord count = Coord(1) << refinement; // of cells in a leaf along each axis
  std::vector<LeafCell> cells;
  cells.reserve(tree.cells.size() << 3 * refinement);
  for (const LeafCell& leaf : tree.cells)
  {
    for (Coord i = 0; i < count * count * count; ++i)
    {
      const std::array<Coord, 3> at{ i % count, i / count % count, i / (count * count) };
      CellId cell{ {}, leaf.cell.level + refinement };
      Vec3 centre;
      for (int a = 0; a < 3; ++a)
      {
        cell.index[a] = (leaf.cell.index[a] << refinement) + at[a];
        centre[a] = std::ldexp(rootWidth * (static_cast<double>(cell.index[a]) + 0.5), -cell.level);
      }
      cells.push_back({ cell, static_cast<float>(values(centre)) });
    }
  }
  auto built = buildOctree(RootGrid::uniform({ BaseTree::roots, BaseTree::roots, BaseTree::roots },
                             { 0., 0., 0. }, { rootWidth, rootWidth, rootWidth }),
    std::move(cells));
  return std::make_shared<Field>(built.octree, std::move(built.values));
}

} // namespace treeamr::report
