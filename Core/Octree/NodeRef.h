// The name of a node of an octree.
#pragma once

#include <cstdint>

namespace treeamr
{

/// What there is at a place.
enum class NodeKind : std::uint8_t
{
  None,
  Leaf, // a cell
  Inner // a node with children
};

/// A node by kind, depth and index among the leaves or inner nodes of the octree.
class NodeRef
{
public:
  NodeRef() noexcept = default;
  /// depth: below 64. index: below 2^56.
  constexpr NodeRef(NodeKind kind, int depth, std::uint64_t index) noexcept
    : bits_(static_cast<std::uint64_t>(kind) << 62 | static_cast<std::uint64_t>(depth) << 56 | index)
  {
  }
  ///@{
  /// What it is.
  constexpr NodeKind kind() const noexcept { return static_cast<NodeKind>(bits_ >> 62); }
  constexpr bool isNone() const noexcept { return kind() == NodeKind::None; }
  constexpr bool isLeaf() const noexcept { return kind() == NodeKind::Leaf; }
  constexpr bool isInner() const noexcept { return kind() == NodeKind::Inner; }
  ///@}
  /// From the octree's padded root.
  constexpr int depth() const noexcept { return static_cast<int>(bits_ >> 56 & 63); }
  /// Among the leaves or among the inner nodes.
  constexpr std::uint64_t index() const noexcept { return bits_ & ((std::uint64_t(1) << 56) - 1); }
  constexpr bool operator==(const NodeRef&) const noexcept = default;

private:
  std::uint64_t bits_; // uninitialised by default, none when value-initialised: paths hold thousands of these
};
static_assert(sizeof(NodeRef) == 8);

} // namespace treeamr
