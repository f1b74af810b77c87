#include "Interpolation/PointSampler.h"

#include <algorithm>
#include <array>

namespace treeamr
{

namespace
{

constexpr std::uint64_t noNode = ~std::uint64_t(0);

std::size_t slotOf(std::uint64_t node, int bits) noexcept
{
  constexpr std::uint64_t golden =
    0x9e3779b97f4a7c15; // spreads neighbours' numbers (Knuth's multiplicative hash)
  return node * golden >> (64 - bits);
}

} // namespace

PointSampler::PointSampler(const Field& field)
  : field_(field)
  , leaves_(field.octree())
  , evaluator_(field)
  , kept_(std::make_unique_for_overwrite<std::uint64_t[]>(std::size_t(1) << keptBits))
  , blocks_(std::make_unique_for_overwrite<BlockValues[]>(std::size_t(1) << keptBits))
  , touched_(std::make_unique_for_overwrite<Touched[]>(std::size_t(1) << touchedBits))
  , path_(field.octree())
{
  std::fill_n(kept_.get(), std::size_t(1) << keptBits, noNode);
  std::fill_n(touched_.get(), std::size_t(1) << touchedBits, Touched{ noNode, 0 });
}

bool PointSampler::sample(const Vec3& pWorld, FieldSample& sample) noexcept
{
  LeafFinder::Leaf leaf;
  if (!leaves_.find(pWorld, leaf))
  {
    return false;
  }
  if (leaf.depth == 0)
  {
    sample = { field_.relative(field_.octree().root()), {} };
    return true;
  }
  const Piece piece = pieceOf(leaf);
  const Bounds box = field_.octree().grid().nodeBounds(leaf.index, leaf.depth);
  sample = { trilinear(piece.corners, piece.place), trilinearGradient(piece.corners, piece.place) };
  for (int a = 0; a < 3; ++a)
  {
    sample.gradient[a] = 2. * sample.gradient[a] / (box.max[a] - box.min[a]);
  }
  return true;
}

bool PointSampler::value(const Vec3& pWorld, double& value) noexcept
{
  LeafFinder::Leaf leaf;
  if (!leaves_.find(pWorld, leaf))
  {
    return false;
  }
  if (leaf.depth == 0)
  {
    value = field_.relative(field_.octree().root());
    return true;
  }
  const Piece piece = pieceOf(leaf);
  value = trilinear(piece.corners, piece.place);
  return true;
}

PointSampler::Piece PointSampler::pieceOf(const LeafFinder::Leaf& leaf) noexcept
{
  Piece piece;
  std::array<int, 3> upper;
  for (int a = 0; a < 3; ++a)
  {
    upper[a] = leaf.place[a] >= 0.5;
    piece.place[a] = 2. * leaf.place[a] - upper[a];
  }
  if (const BlockValues* values = keptBlock())
  {
    const int octant = octantAbove(leaf.index, 0);
    const int first = block::vertexIndex(
      2 * sideOf(octant, 0) + upper[0], 2 * sideOf(octant, 1) + upper[1], 2 * sideOf(octant, 2) + upper[2]);
    piece.corners = cornersOf(values->values.data() + first, block::vertexStride);
  }
  else
  {
    moveTo(leaf);
    piece.corners = octantCorners(path_, field_, memo_, upper[0] | upper[1] << 1 | upper[2] << 2);
  }
  return piece;
}

const BlockValues* PointSampler::keptBlock() noexcept
{
  const BlockPath& path = leaves_.pathToParent();
  const std::uint64_t node = path.node[path.depth];
  const std::size_t slot = slotOf(node, keptBits);
  if (kept_[slot] != node)
  {
    Touched& touched = touched_[slotOf(node, touchedBits)];
    touched = touched.node == node ? Touched{ node, touched.count + 1 } : Touched{ node, 1 };
    if (touched.count < worthABlock)
    {
      return nullptr;
    }
    touched.node = noNode;
    kept_[slot] = node;
    evaluator_.compute(path, BlockCells::Leaves, blocks_[slot]);
    ++computedBlocks_;
  }
  return &blocks_[slot];
}

void PointSampler::moveTo(const LeafFinder::Leaf& leaf) noexcept
{
  const auto isAbove = [&] {
    const int up = leaf.depth - path_.depth();
    const std::array<Coord, 3>& index = path_.index();
    return up >= 0 && leaf.index[0] >> up == index[0] && leaf.index[1] >> up == index[1] &&
      leaf.index[2] >> up == index[2];
  };
  while (!isAbove())
  {
    path_.ascend();
  }
  for (int up = leaf.depth - path_.depth() - 1; up >= 0; --up)
  {
    path_.descend(octantAbove(leaf.index, up));
  }
}

} // namespace treeamr
