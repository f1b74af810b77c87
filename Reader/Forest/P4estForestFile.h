// Forests saved by p8est_save and p4est_save (p4est 0.3.5 to 2.8), read without libp4est: it ends the process on a bad file.
//
// The layout, in the byte order of the machine that wrote it:
//   connectivity   magic "p8est" (8 bytes), version text (24), ten uint64: format 0x3000009, bytes per index
//                  (4), vertices, trees, edges, edge entries, corners, corner entries, attribute bytes per
//                  tree, 0; then vertices (3 double), tree_to_edge, tree_to_vertex, tree_to_corner,
//                  tree_to_tree, tree_to_face (int8), attributes, ett_offset, edge_to_tree, edge_to_edge
//                  (int8), ctt_offset, corner_to_tree, corner_to_corner (int8); int32 where nothing is said.
//                  Without vertices, edges or corners their tables are left out, but for the offsets.
//   at the next multiple of 32 bytes
//   forest header  six uint64: format, bytes per coordinate (4), size of p8est_quadrant_t, payload bytes per
//                  quadrant, whether a payload follows, ranks; per rank the quadrants up to its end; per tree
//                  the quadrants up to its end
//   at the next multiple of 32 bytes
//   quadrants      int32 x, y, z, level and the payload, tree by tree in Morton order; anything may follow
// Those of two dimensions have magic "p4est", format 0x2000009, four corners, four faces and no z: nothing of edges, not
// even an offset.
// A tree is 2^19 coordinates wide up to p4est 2.2 and 2^30 from 2.3 on, under the same format code: the
// second quadrant of a refined tree tells which. In two dimensions it is always 2^30.
#pragma once

#include "Forest/TreeLeaf.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace treeamr
{

class P4estInputFile;

/// Where the trees are: all of the connectivity that is kept. The other tables are only checked. Those of two dimensions are
/// as boxes over the plane, whose first four corners are the tree's own.
struct P4estConnectivity
{
  /// None in a connectivity that is topology alone.
  std::vector<std::array<double, 3>> vertices;
  /// The eight corners of each tree, x fastest; none without vertices.
  std::vector<std::array<std::int32_t, 8>> treeVertices;
  /// What is beyond a face of a tree: a face of another one, or itself at a boundary.
  struct Neighbour
  {
    std::int32_t tree;
    std::int8_t face;
    /// Face corner 0 of the face of the lower number is at this face corner of the other (p4est_connectivity.h).
    std::int8_t orientation;
  };
  /// Of the faces -x, +x, -y, +y, -z, +z of each tree; none with vertices.
  std::vector<std::array<Neighbour, 6>> neighbours;
  /// The corners of each tree, x fastest, by numbers that trees share, or -1; none with vertices or without corners.
  std::vector<std::array<std::int32_t, 8>> treeCorners;
};

class P4estForestFile
{
public:
  /// The deepest quadrants of any p4est; up to 2.2 it is 18.
  static constexpr int maxLevel = 29;

  /// Reads and checks everything before the quadrants, and that they fit the file; no memory is asked for
  /// before the file is known to fill it. Throws Error naming the file, the section, what was found and what
  /// is allowed, also for the other byte order and files that hold a connectivity only.
  explicit P4estForestFile(std::string path);

  /// Whether the file starts as a 2-D or 3-D forest or connectivity does.
  static bool hasMagic(const std::string& path) noexcept;

  const std::string& path() const noexcept { return path_; }
  /// 2 or 3.
  int dimension() const noexcept { return dimension_; }
  const P4estConnectivity& connectivity() const noexcept { return connectivity_; }
  std::int32_t treeCount() const noexcept { return static_cast<std::int32_t>(treeEnds_.size()); }
  std::uint64_t quadrantCount() const noexcept { return treeEnds_.back(); }
  std::uint64_t quadrantCount(std::int32_t tree) const noexcept
  {
    return treeEnds_[tree] - (tree > 0 ? treeEnds_[tree - 1] : 0);
  }
  /// Quadrants and all their ancestors. A tree is complete, so each of its inner nodes adds seven quadrants, or three.
  std::uint64_t nodeCount(std::int32_t tree) const noexcept
  {
    return quadrantCount(tree) + (quadrantCount(tree) - 1) / ((std::uint64_t(1) << dimension_) - 1);
  }
  /// Bytes per quadrant; 0 when the forest was saved without data.
  std::size_t payloadSize() const noexcept { return payloadSize_; }

  /// Reads the quadrants of ascending ranges, tree by tree in Morton order, on any number of threads at once. Each is checked
  /// beside the one before it: a level out of range, a place off its level's lattice, a gap, an overlap or a false order is an
  /// Error. What was read is right when all up to it is.
  void readQuadrants(std::span<const LeafRange> ranges, LeafBlock& block) const;
  /// As many as make a range of about half a MiB.
  std::uint64_t blockQuadrants() const noexcept;

  /// Where quadrants from `first` on have their lower corners, in coordinates of which a tree is 2^rootBits() wide; not checked.
  /// file: this one, open.
  void readAnchors(
    P4estInputFile& file, std::uint64_t first, std::span<std::array<std::int32_t, 3>> anchors) const;
  int rootBits() const noexcept { return rootBits_; }

  /// Visits all quadrants; after an Error what was visited before it must be thrown away.
  void visitQuadrants(const std::function<void(const TreeLeaf&)>& visit) const;

  /// Visits the payloads of all quadrants or, when these are more than `count`, of about as many in blocks
  /// spread over the file. The quadrants are not checked.
  void samplePayloads(std::uint64_t count, const std::function<void(const std::byte*)>& visit) const;

private:
  void appendQuadrants(
    P4estInputFile& file, const LeafRange& range, std::byte* bytes, LeafBlock& block) const;

  std::string path_;
  int dimension_ = 3;
  P4estConnectivity connectivity_;
  std::vector<std::uint64_t> treeEnds_; // quadrants up to the end of each tree; never empty
  std::size_t payloadSize_ = 0;
  std::uint64_t quadrantsOffset_ = 0; // bytes
  int rootBits_ = 0;
};

} // namespace treeamr
