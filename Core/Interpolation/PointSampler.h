// The GTI reconstruction at points: what a Sampler (Sampler.h) of this method asks in each of its threads.
//
// The first points in a block of leaves have the vertices of their own octants evaluated. As many points as take as long
// have those of all of the block evaluated (BlockValues.h), and kept. The way down the tree starts at the last point's. So points near each
// other cost a fraction of points apart, and these no more than each by itself.
#pragma once

#include "Geometry/Trilinear.h"
#include "Interpolation/BlockValues.h"
#include "Interpolation/LeafFinder.h"
#include "Interpolation/Sampler.h"
#include "Interpolation/VertexValues.h"

#include <cstdint>
#include <memory>

namespace treeamr
{

/// Of one field, which must live as long, for one thread.
class PointSampler
{
public:
  explicit PointSampler(const Field& field);

  /// As Sampler::sampleRelative().
  bool sample(const Vec3& pWorld, FieldSample& sample) noexcept;
  /// The same without the gradient.
  bool value(const Vec3& pWorld, double& value) noexcept;

  /// How often the values of a block were computed.
  std::uint64_t computedBlocks() const noexcept { return computedBlocks_; }

private:
  /// The octant of a leaf that a point is in.
  struct Piece
  {
    Corners corners;
    Vec3 place; // 0 to 1
  };

  Piece pieceOf(const LeafFinder::Leaf& leaf) noexcept;
  /// Above the leaf found last; null when it is not worth computing yet.
  const BlockValues* keptBlock() noexcept;
  void moveTo(const LeafFinder::Leaf& leaf) noexcept;

  // Tables by hashed numbers of nodes, the last one at each place. A row of pixels meets as many blocks, or a tile of
  // rays.
  static constexpr int keptBits = 9;
  static constexpr int touchedBits = 10;
  /// Points one by one that take about as long as a block.
  static constexpr int worthABlock = 4;
  struct Touched
  {
    std::uint64_t node;
    int count; // of points in it
  };

  const Field& field_;
  LeafFinder leaves_;
  BlockEvaluator evaluator_;
  std::unique_ptr<std::uint64_t[]> kept_; // nodes of the blocks kept
  std::unique_ptr<BlockValues[]> blocks_;
  std::unique_ptr<Touched[]> touched_;
  TreePath path_; // to the last leaf that was evaluated by itself
  VertexMemo memo_;
  std::uint64_t computedBlocks_ = 0;
};

} // namespace treeamr
