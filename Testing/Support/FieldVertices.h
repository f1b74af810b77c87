// The values and gradients at all vertices of the leaves in a box, and how many differ between two fields.
#pragma once

#include "Interpolation/BlockGradients.h"
#include "Interpolation/BlockValues.h"
#include "Partition/LatticeBox.h"
#include "Support/RandomTrees.h"

#include <array>
#include <cstring>
#include <map>

namespace treeamr::test
{

using VertexPlace = std::array<Coord, 3>; // on the lattice of the finest octants

struct AtVertex
{
  double value;
  Vec3 gradient;
};

/// Of the leaves that meet a box, and of the others of their parents.
inline std::map<VertexPlace, AtVertex> verticesIn(const Field& field, const LatticeBox& box, int leafLevels)
{
  std::map<VertexPlace, AtVertex> all;
  BlockEvaluator ofValues(field);
  GradientEvaluator ofGradients(field);
  const Octree& octree = field.octree();
  const int padding = octree.grid().paddingDepth();
  TreePath root(octree);
  forEachNode(root, [&](const TreePath& at) {
    if (!at.node().isInner())
    {
      return;
    }
    const Octree::Children children = octree.children(at.node().index());
    BlockVertices vertices{};
    bool meets = false;
    for (int o = 0; o < 8; ++o)
    {
      const CellId child{ indexOfChild(at.index(), o), at.depth() + 1 - padding };
      meets = meets || ((children.leaf >> o & 1) != 0 && box.meets(child));
    }
    for (int o = 0; meets && o < 8; ++o)
    {
      if ((children.leaf >> o & 1) == 0)
      {
        continue;
      }
      for (int v = 0; v < 27; ++v)
      {
        add(vertices, 2 * sideOf(o, 0) + v % 3, 2 * sideOf(o, 1) + v / 3 % 3, 2 * sideOf(o, 2) + v / 9);
      }
    }
    if (vertices == BlockVertices{})
    {
      return;
    }
    const BlockPath path(at);
    BlockValues values;
    ofValues.compute(path, BlockCells::Leaves, values);
    BlockGradients gradients;
    ofGradients.compute(path, BlockCells::Leaves, vertices, gradients);
    const int up = padding + leafLevels - 1 - at.depth();
    forEachVertex(vertices, [&](int v) {
      VertexPlace place{ v % 5, v / 5 % 5, v / 25 };
      for (int a = 0; a < 3; ++a)
      {
        place[a] = (4 * at.index()[a] + place[a]) << up;
      }
      all[place] = { values.values[v], gradients[v] };
    });
  });
  return all;
}

template <class T>
bool sameBits(const T& a, const T& b)
{
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

/// Bit for bit.
struct VertexDifferences
{
  std::size_t compared = 0;
  std::size_t missing = 0; // in one of the fields
  std::size_t values = 0;
  std::size_t gradients = 0;

  void compare(const Field& expected, const Field& found, const LatticeBox& box)
  {
    const int levels = expected.octree().leafLevels();
    const auto one = verticesIn(expected, box, levels);
    const auto other = verticesIn(found, box, levels);
    missing += one.size() > other.size() ? one.size() - other.size() : other.size() - one.size();
    for (const auto& [place, at] : one)
    {
      const auto same = other.find(place);
      if (same == other.end())
      {
        ++missing;
        continue;
      }
      ++compared;
      values += !sameBits(at.value, same->second.value);
      gradients += !sameBits(at.gradient, same->second.gradient);
    }
  }
};

} // namespace treeamr::test
