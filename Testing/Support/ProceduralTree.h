// A source of an octree of any size that stores nothing: cells become smaller towards a wavy sheet, next to
// which those of the deepest level are.
#pragma once

#include "Octree/OctreeBuilder.h"

#include <array>
#include <cmath>

namespace treeamr::test
{

/// On the unit cube, one tree. A cell is refined while the sheet passes within `widths` of its own widths
/// above or below its centre.
/// About 4.7 * widths * 4^deepest cells: 200M for (12, 2.55).
class ProceduralTree
{
public:
  struct Handle
  {
    std::array<std::int32_t, 3> index;
    std::int32_t level;
  };

  ProceduralTree(int deepest, double widths)
    : deepest_(deepest)
    , widths_(widths)
  {
  }

  static std::size_t rootCount() { return 1; }
  static std::array<Coord, 3> rootPlace(std::size_t /*tree*/) { return {}; }
  static Handle root(std::size_t /*tree*/) { return {}; }
  NodeKind kind(const Handle& node) const
  {
    const bool refined =
      node.level < deepest_ && std::abs(heightAboveSheet(centre(node))) < std::ldexp(widths_, -node.level);
    return refined ? NodeKind::Inner : NodeKind::Leaf;
  }
  static Handle child(const Handle& node, int octant)
  {
    return { { 2 * node.index[0] + (octant & 1), 2 * node.index[1] + (octant >> 1 & 1),
               2 * node.index[2] + (octant >> 2) },
      node.level + 1 };
  }
  static float value(const Handle& node) { return static_cast<float>(field(centre(node))); }
  static constexpr bool ghosts() { return false; }
  static constexpr bool isGhost(const Handle& /*node*/) { return false; }

  static std::array<double, 3> centre(const Handle& node)
  {
    std::array<double, 3> p;
    for (int a = 0; a < 3; ++a)
    {
      p[a] = std::ldexp(node.index[a] + 0.5, -node.level);
    }
    return p;
  }
  static double heightAboveSheet(const std::array<double, 3>& p)
  {
    return p[1] - 0.5 - 0.08 * std::sin(9. * p[0] + 2. * std::sin(5. * p[2]));
  }
  /// In [0, 1], highest in the sheet.
  static double field(const std::array<double, 3>& p)
  {
    const double s = heightAboveSheet(p) / 0.025;
    return std::exp(-0.5 * s * s) * (0.6 + 0.4 * std::sin(40. * p[0]) * std::sin(31. * p[2]));
  }

private:
  int deepest_;
  double widths_;
};

} // namespace treeamr::test
