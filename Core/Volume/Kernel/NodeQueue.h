#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace treeamr
{

/// Nodes that are still to be visited, the most promising one first. Node: has a `most`, what it reaches at best, and a
/// `least`, what it reaches in any case. Beside the kernel, not in it: the library's algorithms are compiled for all
/// instruction sets and could not inline what is compiled for one.
template <class Node>
class NodeQueue
{
public:
  bool isEmpty() const noexcept { return order_.empty(); }

  void push(const Node& node)
  {
    auto slot = static_cast<std::uint32_t>(nodes_.size());
    if (free_.empty())
    {
      nodes_.push_back(node);
    }
    else
    {
      slot = free_.back();
      free_.pop_back();
      nodes_[slot] = node;
    }
    order_.push_back({ node.most, node.least, pushed_++, slot });
    std::push_heap(order_.begin(), order_.end());
  }

  /// Removes the one with the largest `most`. Of several the one with the largest `least`, of these the last one: so
  /// fewer are left to wait.
  Node pop()
  {
    std::pop_heap(order_.begin(), order_.end());
    const std::uint32_t slot = order_.back().slot;
    order_.pop_back();
    free_.push_back(slot);
    return nodes_[slot];
  }

private:
  struct Place
  {
    decltype(Node::most) most;
    decltype(Node::most) least;
    std::uint32_t when;
    std::uint32_t slot;

    bool operator<(const Place& other) const noexcept
    {
      if (most != other.most)
      {
        return most < other.most;
      }
      return least != other.least ? least < other.least : when < other.when;
    }
  };

  std::vector<Place> order_; // a heap
  std::vector<Node> nodes_;  // by slot
  std::vector<std::uint32_t> free_;
  std::uint32_t pushed_ = 0;
};

} // namespace treeamr
