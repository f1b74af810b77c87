// The blocks that the rays of a tile come to, found for all rays together.
//
// Rays that end at their first hit ask Embree, packet by packet. Where all layers are wanted, each packet would be told
// of every block on its way, which are those of its neighbours: here a tile's rays go down the blocks' boxes as one
// beam, and only the blocks that it meets are looked at by packets.
#pragma once

#include "LargeArray.h"
#include "Surface/BlockIntersection.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace treeamr
{

/// Boxes of blocks, or of as many such, side by side, where the domain is a unit cube. Missing ones are turned inside
/// out: nothing meets them.
struct alignas(64) BoxGroup
{
  static constexpr int size = 8;
  std::array<std::array<float, size>, 3> low; // by axis
  std::array<std::array<float, size>, 3> high;
};

/// Boxes of a hierarchy's levels: those of the blocks, then those of the groups before, until one group is left.
using BoxLevels = std::vector<LargeVector<BoxGroup>>;

/// Adds the blocks that some of the first `count` rays may come to, each once, with the packets of these rays: no other
/// packet's ray enters the block (see enterBlock()).
void findBlocks(const TraceSpace& space, const BoxLevels& levels, const SlabRays& rays, int count,
  std::vector<MetBlock>& found);

class BlockBoxes
{
public:
  explicit BlockBoxes(const BlockIntersection& intersection);

  /// Draws them tighter as SurfaceHierarchy::update() does. While no thread asks for blocks.
  void update();
  /// Those of the tile's rays. Safe from several threads, for tiles of their own.
  void find(RayTile& tile) const;
  std::size_t byteSize() const noexcept;

private:
  void fill();

  const BlockIntersection& intersection_;
  BoxLevels levels_;
  std::uint64_t computedBefore_; // of the blocks' values
};

} // namespace treeamr
