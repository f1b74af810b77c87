// A list of cells as a source of OctreeBuilder.h, with ghosts.
#pragma once

#include "Octree/OctreeBuilder.h"

#include <array>
#include <map>
#include <utility>
#include <vector>

namespace treeamr::test
{

class ListSource
{
public:
  using Handle = CellId;

  ListSource(const std::array<int, 3>& roots, const std::vector<LeafCell>& cells)
    : roots_(roots)
  {
    for (const LeafCell& c : cells)
    {
      nodes_[key(c.cell)] = { NodeKind::Leaf, c.value };
      for (CellId up = c.cell; up.level-- > 0;)
      {
        for (auto& x : up.index)
        {
          x >>= 1;
        }
        nodes_[key(up)] = { NodeKind::Inner, 0.f };
      }
    }
  }
  std::size_t rootCount() const
  {
    return static_cast<std::size_t>(roots_[0]) * static_cast<std::size_t>(roots_[1] * roots_[2]);
  }
  std::array<Coord, 3> rootPlace(std::size_t i) const // z fastest, to be sorted
  {
    const auto r = static_cast<Coord>(i);
    return { r / roots_[2] / roots_[1], r / roots_[2] % roots_[1], r % roots_[2] };
  }
  CellId root(std::size_t i) const { return { rootPlace(i), 0 }; }
  NodeKind kind(const CellId& c) const
  {
    const auto found = nodes_.find(key(c));
    return found == nodes_.end() ? NodeKind::None : found->second.first;
  }
  CellId child(const CellId& c, int o) const
  {
    return { { 2 * c.index[0] + (o & 1), 2 * c.index[1] + (o >> 1 & 1), 2 * c.index[2] + (o >> 2) },
      c.level + 1 };
  }
  float value(const CellId& c) const { return nodes_.at(key(c)).second; }
  bool ghosts() const { return true; }
  bool isGhost(const CellId& c) const { return value(c) < ghostsBelow; }

  float ghostsBelow = -2.f; // cells with a lower value are ghosts

private:
  using Key = std::array<Coord, 4>;
  static Key key(const CellId& c) { return { c.level, c.index[0], c.index[1], c.index[2] }; }
  std::array<int, 3> roots_;
  std::map<Key, std::pair<NodeKind, float>> nodes_;
};

} // namespace treeamr::test
