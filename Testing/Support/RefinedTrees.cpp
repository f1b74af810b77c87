#include "Support/RefinedTrees.h"

#include "Support/Cameras.h"
#include "Support/RandomTrees.h"

#include <cmath>
#include <numbers>

namespace treeamr::test
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

double degreesBetween(const Vec3& a, const Vec3& b)
{
  const Vec3 sine = cross(a, b);
  return std::atan2(std::sqrt(dot(sine, sine)), dot(a, b)) * 180. / std::numbers::pi;
}

std::vector<AnalyticSurface> makeAnalyticSurfaces()
{
  constexpr Vec3 centre{ 0.51, 0.49, 0.505 };
  const auto sphere = [=](const Vec3& p) {
    const Vec3 d = p - centre;
    return std::sqrt(dot(d, d));
  };
  const auto torus = [=](const Vec3& p) {
    const Vec3 axis = normalized({ 1., 2., 3. });
    const Vec3 d = p - centre;
    const Vec3 across = cross(d, axis);
    return std::hypot(std::sqrt(dot(across, across)) - 0.22, dot(d, axis));
  };
  return { { "sphere", sphere, 0.34 }, { "torus", torus, 0.12 } };
}

double BaseTree::finestWidth(int refinement) const
{
  return std::ldexp(1. / roots, -(levels + refinement));
}

std::vector<BaseTree> makeBaseTrees()
{
  constexpr std::array<int, 3> roots{ BaseTree::roots, BaseTree::roots, BaseTree::roots };
  const auto make = [&](const char* name, int levels, double refine, bool balanced) {
    return BaseTree{ name, makeRandomTree({ 11, roots, levels, refine, 0., balanced }), levels };
  };
  return { make("uniform", 1, 1., false), make("one-level", 3, 0.2, true),
    make("four-levels", 4, 0.25, false) };
}

namespace
{

constexpr double rootWidth = 1. / BaseTree::roots;

double widthOf(const CellId& cell)
{
  return std::ldexp(rootWidth, -cell.level);
}

Vec3 centreOf(const CellId& cell)
{
  Vec3 centre;
  for (int a = 0; a < 3; ++a)
  {
    centre[a] = widthOf(cell) * (static_cast<double>(cell.index[a]) + 0.5);
  }
  return centre;
}

std::shared_ptr<Field> makeField(std::vector<LeafCell> cells)
{
  auto built = buildOctree(RootGrid::uniform({ BaseTree::roots, BaseTree::roots, BaseTree::roots },
                             { 0., 0., 0. }, { rootWidth, rootWidth, rootWidth }),
    std::move(cells));
  return std::make_shared<Field>(built.octree, std::move(built.values));
}

/// Divides a cell so many times, but parts of it farther from the surface than `margin`.
void divideNear(
  const CellId& cell, int times, const AnalyticSurface& surface, double margin, std::vector<LeafCell>& cells)
{
  const double distance = surface.field(centreOf(cell)) - surface.isovalue;
  const double halfDiagonal = 0.5 * std::sqrt(3.) * widthOf(cell);
  if (times == 0 || std::abs(distance) > halfDiagonal + margin)
  {
    cells.push_back({ cell, static_cast<float>(surface.field(centreOf(cell))) });
    return;
  }
  for (int child = 0; child < 8; ++child)
  {
    CellId part{ {}, cell.level + 1 };
    for (int a = 0; a < 3; ++a)
    {
      part.index[a] = 2 * cell.index[a] + (child >> a & 1);
    }
    divideNear(part, times - 1, surface, margin, cells);
  }
}

} // namespace

std::shared_ptr<Field> makeField(const BaseTree& tree, int refinement, const AnalyticField& values)
{
  const Coord count = Coord(1) << refinement; // of cells in a leaf along each axis
  std::vector<LeafCell> cells;
  cells.reserve(tree.cells.size() << 3 * refinement);
  for (const LeafCell& leaf : tree.cells)
  {
    for (Coord i = 0; i < count * count * count; ++i)
    {
      const std::array<Coord, 3> at{ i % count, i / count % count, i / (count * count) };
      CellId cell{ {}, leaf.cell.level + refinement };
      for (int a = 0; a < 3; ++a)
      {
        cell.index[a] = (leaf.cell.index[a] << refinement) + at[a];
      }
      cells.push_back({ cell, static_cast<float>(values(centreOf(cell))) });
    }
  }
  return makeField(std::move(cells));
}

std::shared_ptr<Field> makeFieldNear(const BaseTree& tree, int refinement, const AnalyticSurface& surface)
{
  constexpr double largestCells =
    4.; // what vertex gradients at the surface are made of lies within three of these
  const double margin = largestCells * std::ldexp(rootWidth, -refinement);
  std::vector<LeafCell> cells;
  for (const LeafCell& leaf : tree.cells)
  {
    divideNear(leaf.cell, refinement, surface, margin, cells);
  }
  return makeField(std::move(cells));
}

} // namespace treeamr::test
