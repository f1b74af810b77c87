// Which of the boxes that cutBoxes() made a place lies in, found along the cuts.
#pragma once

#include "Partition/LatticeBox.h"

#include <algorithm>
#include <vector>

namespace treeamr
{

class BoxTree
{
public:
  /// boxes: of one level, disjoint; in an order of which halves lie together, as cutBoxes() gives them, or else it is slower.
  explicit BoxTree(const std::vector<LatticeBox>& boxes)
  {
    if (!boxes.empty())
    {
      add(boxes, 0, static_cast<int>(boxes.size()));
    }
  }
  /// place: on the lattice of their level. -1: in none.
  int find(const std::array<Coord, 3>& place) const noexcept { return nodes_.empty() ? -1 : find(0, place); }

private:
  struct Node
  {
    std::array<Coord, 3> begin; // around all boxes of the part
    std::array<Coord, 3> end;
    int second; // node of the upper half, after that of the lower; or ~ the only box
  };

  int add(const std::vector<LatticeBox>& boxes, int first, int count)
  {
    const int number = static_cast<int>(nodes_.size());
    nodes_.push_back({});
    if (count == 1)
    {
      const LatticeBox& box = boxes[static_cast<std::size_t>(first)];
      nodes_[static_cast<std::size_t>(number)] = { box.begin, box.isEmpty() ? box.begin : box.end, ~first };
      return number;
    }
    const int lowerCount = (count + 1) / 2;
    const int lower = add(boxes, first, lowerCount);
    const int upper = add(boxes, first + lowerCount, count - lowerCount);
    Node node = around(nodes_[static_cast<std::size_t>(lower)], nodes_[static_cast<std::size_t>(upper)]);
    node.second = upper;
    nodes_[static_cast<std::size_t>(number)] = node;
    return number;
  }
  static bool isEmpty(const Node& node) noexcept { return node.begin == node.end; }
  static Node around(Node a, const Node& b) noexcept
  {
    if (isEmpty(a) || isEmpty(b))
    {
      return isEmpty(a) ? b : a;
    }
    for (int axis = 0; axis < 3; ++axis)
    {
      a.begin[axis] = std::min(a.begin[axis], b.begin[axis]);
      a.end[axis] = std::max(a.end[axis], b.end[axis]);
    }
    return a;
  }
  int find(int number, const std::array<Coord, 3>& place) const noexcept
  {
    const Node& node = nodes_[static_cast<std::size_t>(number)];
    for (int a = 0; a < 3; ++a)
    {
      if (place[a] < node.begin[a] || place[a] >= node.end[a])
      {
        return -1;
      }
    }
    if (node.second < 0)
    {
      return ~node.second;
    }
    const int found = find(number + 1, place);
    return found >= 0 ? found : find(node.second, place);
  }

  std::vector<Node> nodes_; // a node, its lower half, its upper half
};

} // namespace treeamr
