// The vertex values of all children of one inner node at once: what VertexValues.h gives leaf by leaf.
//
// The children's vertices form a lattice of 5 x 5 x 5 points, which eight leaves share: 125 values instead of
// 8 x 27, found from the 4 x 4 x 4 cells of the children's size in and around the node; of a field that is given at
// corners, from those of the leaves alone.
#pragma once

#include "Field/CornerValues.h"
#include "Field/Field.h"
#include "Interpolation/BlockLattice.h"
#include "Octree/TreePath.h"

#include <array>
#include <cstdint>
#include <memory>

namespace treeamr
{

struct BlockValues
{
  /// Order x + 5 y + 25 z with x, y, z in 0 to 4 half widths of a child from the node's lower corner.
  /// Vertices that no drawn child has hold some value of the range.
  std::array<float, block::vertexCount> values;
  Range range; // hull of the drawn children's vertex values
};

/// The inner nodes from the root down to one.
struct BlockPath
{
  int depth = 0;
  std::array<std::uint64_t, Octree::maxDepth + 1> node{}; // by depth; the root is 0
  std::array<std::uint8_t, Octree::maxDepth> octant{};    // of the node below each depth

  BlockPath() noexcept = default;
  /// To the inner node that a path has arrived at.
  explicit BlockPath(const TreePath& path) noexcept
  {
    for (int d = 1; d <= path.depth(); ++d)
    {
      const std::array<Coord, 3>& index = path.index(d);
      descend(octantAbove(index, 0), path.around(d)[13].index());
    }
  }

  /// To the inner node at an index on the lattice of a depth: it must exist.
  BlockPath(const Octree& octree, const std::array<Coord, 3>& index, int to) noexcept
  {
    descendTo(octree, index, to);
  }

  /// To another such node, from where the ways part.
  void moveTo(const Octree& octree, const std::array<Coord, 3>& index, int to) noexcept
  {
    int common = 0;
    while (common < std::min(depth, to) && octant[common] == octantAbove(index, to - 1 - common))
    {
      ++common;
    }
    depth = common;
    descendTo(octree, index, to);
  }

  void descend(int childOctant, std::uint64_t child) noexcept
  {
    octant[depth] = static_cast<std::uint8_t>(childOctant);
    node[++depth] = child;
  }
  void ascend() noexcept { --depth; }

private:
  void descendTo(const Octree& octree, const std::array<Coord, 3>& index, int to) noexcept
  {
    while (depth < to)
    {
      const int at = octantAbove(index, to - 1 - depth);
      descend(at, octree.children(node[depth]).innerIndex(at));
    }
  }
};

/// The corners of the leaves among the children of the node at a path's end; of an octree whose root is a leaf, this one's.
inline CornerValues::Family familyOf(
  const CornerValues& corners, const Octree& octree, const BlockPath& path) noexcept
{
  const int depth = path.depth;
  return octree.root().isLeaf() ? corners.onlyLeaf()
    : depth == 0                ? corners.family(0, 0, 0, 0)
                 : corners.family(depth, path.node[depth], path.node[depth - 1], path.octant[depth - 1]);
}

enum class BlockCells
{
  Leaves, // the leaves among the children
  Means   // all children, refined ones and their like around by their means: level of detail
};

/// GTI at the vertices of the children of an inner node, for leaves the same values bit for bit as
/// vertexValues() gives for each. The path must end at the inner node. Vertices that hang on coarser faces are
/// kept while a walk stays below their node.
///
/// Of a field given at corners, leaves have the values between these. An octree whose root is a leaf has one block, at the
/// path's depth 0, whose child 0 the leaf is.
class BlockEvaluator
{
public:
  explicit BlockEvaluator(const Field& field)
    : field_(field)
    , octree_(field.octree())
    , corners_(field.corners())
    , levels_(
        std::make_unique_for_overwrite<Level[]>(octree_.grid().paddingDepth() + octree_.leafLevels() + 2))
  {
    startAboveRoot();
  }
  /// Needs a drawn child.
  void compute(const BlockPath& path, BlockCells cells, BlockValues& block) noexcept;
  /// The values before they are rounded to float.
  void computeUnrounded(
    const BlockPath& path, BlockCells cells, std::array<double, block::vertexCount>& values) noexcept;
  /// Contains the hull of a node with leaves among its children, for a fraction of the time: the hull where all
  /// cells around are of one size, otherwise that of the values that take part.
  Range bounds(const BlockPath& path) noexcept;

private:
  /// The places in and around an inner node, x + 4 y + 16 z, what their children are, and the vertices that are not
  /// plain means of them (see BlockLattice.h). Masks have a bit per place.
  struct Level
  {
    std::uint64_t node = noNode;
    std::uint64_t refined;     // places that are inner nodes
    std::uint64_t mixed;       // refined places not all of whose children are leaves
    std::uint64_t coarse;      // places that are parts of coarser leaves
    std::uint64_t none;        // places without a cell
    std::uint64_t missing;     // places without a cell or without a child that matters
    std::uint64_t filled;      // places whose childValue is known
    bool deep;                 // whether some coarse leaf is coarser than the node
    block::VertexMask hanging; // vertices that touch a coarse place
    block::VertexMask known;   // vertices whose value is in `special`
    std::array<double, block::vertexCount> special;
    /// Of a leaf of any size its value, of a refined place its mean; then room for eight.
    std::array<double, block::placeCount + 8> value;
    std::array<Octree::Children, block::placeCount> children; // of refined places
    /// Values of the places' children, x + 8 y + 64 z; a leaf's are its own, 0 where there is no cell.
    std::array<double, block::childCount> childValue;
    // A mask for each z of the places' children:
    std::array<std::uint64_t, 8> childInner; // inner nodes in refined places
    std::array<std::uint64_t, 8> childNone;  // children without a cell
  };
  static constexpr std::uint64_t noNode = ~std::uint64_t(0);

  void startAboveRoot() noexcept;
  void gather(const BlockPath& path, int depth, Level& level) noexcept;
  void open(const Level* parent, int octant, Level& level) const noexcept;
  void fill(Level& level, std::uint64_t places) const noexcept;
  Level& levelAt(const BlockPath& path, int depth) noexcept;
  Level& withSpecial(const BlockPath& path, int depth, const block::VertexMask& vertices) noexcept;
  void computeSpecial(
    const BlockPath& path, int depth, Level& level, const block::VertexMask& wanted, double* out) noexcept;
  int leafDepth(const BlockPath& path, int depth, int place) noexcept;
  double hangingDeep(const BlockPath& path, int depth, const Level& level, unsigned axes, int place) noexcept;
  void evaluate(const BlockPath& path, BlockCells cells) noexcept;
  void evaluateCorners(const BlockPath& path) noexcept;

  const Field& field_;
  const Octree& octree_;
  const CornerValues* corners_;     // null: the values are those at centres
  std::unique_ptr<Level[]> levels_; // by 1 + depth of the inner node; the first is above the root
  Level byMeans_;
  unsigned drawn_;                                    // children whose vertices are wanted
  std::array<double, block::vertexCount + 3> values_; // with room for whole vectors
};

} // namespace treeamr
