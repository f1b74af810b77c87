#include "Support/RandomTrees.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

namespace treeamr::test
{

namespace
{

using Index = std::array<Coord, 3>;

/// Adds what 2:1 balance demands to the refined cells, per level.
void balance(std::vector<std::set<Index>>& refined, const std::array<int, 3>& roots)
{
  for (std::size_t level = refined.size() - 1; level > 0; --level)
  {
    for (const Index& cell : refined[level])
    {
      for (int n = 0; n < 27; ++n)
      {
        Index neighbour{ cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1 };
        bool inside = true;
        for (int a = 0; a < 3; ++a)
        {
          inside = inside && neighbour[a] >= 0 && neighbour[a] < Coord(roots[a]) << level;
        }
        if (inside)
        {
          refined[level - 1].insert({ neighbour[0] >> 1, neighbour[1] >> 1, neighbour[2] >> 1 });
        }
      }
    }
  }
}

} // namespace

std::vector<LeafCell> makeRandomTree(const RandomTree& o)
{
  std::mt19937 random(o.seed);
  std::uniform_real_distribution<double> unit(0., 1.);
  std::vector<std::set<Index>> refined(std::max(o.levels, 1));
  std::vector<Index> frontier;
  for (Coord k = 0; k < o.roots[2]; ++k)
  {
    for (Coord j = 0; j < o.roots[1]; ++j)
    {
      for (Coord i = 0; i < o.roots[0]; ++i)
      {
        frontier.push_back({ i, j, k });
      }
    }
  }
  const std::vector<Index> rootCells = frontier;
  for (int level = 0; level < o.levels; ++level)
  {
    std::vector<Index> next;
    for (const Index& c : frontier)
    {
      // A few cells only are refined on every level: the tree stays small and reaches its depth.
      if (unit(random) < o.refine)
      {
        refined[level].insert(c);
        for (int child = 0; child < 8; ++child)
        {
          next.push_back({ 2 * c[0] + (child & 1), 2 * c[1] + (child >> 1 & 1), 2 * c[2] + (child >> 2) });
        }
      }
    }
    std::shuffle(next.begin(), next.end(), random);
    next.resize(std::min<std::size_t>(next.size(), 160));
    frontier = next;
  }
  if (o.balanced)
  {
    balance(refined, o.roots);
  }
  std::vector<LeafCell> cells;
  std::vector<CellId> stack;
  for (const Index& r : rootCells)
  {
    stack.push_back({ r, 0 });
  }
  while (!stack.empty())
  {
    const CellId c = stack.back();
    stack.pop_back();
    if (c.level < o.levels && refined[c.level].count(c.index))
    {
      for (int child = 0; child < 8; ++child)
      {
        stack.push_back({ { 2 * c.index[0] + (child & 1), 2 * c.index[1] + (child >> 1 & 1),
                            2 * c.index[2] + (child >> 2) },
          c.level + 1 });
      }
    }
    else if (unit(random) >= o.missing || (cells.empty() && stack.empty()))
    {
      cells.push_back({ c, static_cast<float>(2. * unit(random) - 1.) });
    }
  }
  std::shuffle(cells.begin(), cells.end(), random);
  return cells;
}

std::array<double, 3> centre(const CellId& cell)
{
  std::array<double, 3> p;
  for (int a = 0; a < 3; ++a)
  {
    p[a] = std::ldexp(static_cast<double>(cell.index[a]) + 0.5, -cell.level);
  }
  return p;
}

void setValues(std::vector<LeafCell>& cells, const std::function<double(const std::array<double, 3>&)>& f)
{
  for (LeafCell& c : cells)
  {
    c.value = static_cast<float>(f(centre(c.cell)));
  }
}

std::vector<RandomTree> propertyTrees()
{
  std::vector<RandomTree> trees;
  const std::array<std::array<int, 3>, 3> roots{ { { 1, 1, 1 }, { 2, 2, 2 }, { 3, 1, 2 } } };
  std::uint32_t seed = 1;
  for (const auto& r : roots)
  {
    for (int repeat = 0; repeat < 3; ++repeat)
    {
      trees.push_back({ seed++, r, 4, 0.7, 0., true });
      trees.push_back({ seed++, r, 5, 0.5, 0., false });
      trees.push_back({ seed++, r, 4, 0.7, 0.2, true });
      trees.push_back({ seed++, r, 5, 0.6, 0.3, false });
    }
  }
  return trees;
}

void forEachNode(TreePath& path, const std::function<void(const TreePath&)>& f)
{
  f(path);
  for (int o = 0; path.node().isInner() && o < 8; ++o)
  {
    if (!path.octree().child(path.node(), o).isNone())
    {
      path.descend(o);
      forEachNode(path, f);
      path.ascend();
    }
  }
}

} // namespace treeamr::test
