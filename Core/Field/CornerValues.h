// The values of a field that is given at the corners of leaves and trilinear in each of them (finite elements Q1).
//
// A corner is stored once for all leaves of a brick: an inner node of every other depth with the leaves among its
// children and grandchildren, whose corners lie on a lattice of 5 x 5 x 5, a quarter of its width apart. That takes
// from 2 (64 leaves) to 8 floats a leaf, on the usual trees 2 to 3, and finds the corners of a node's children at once.
//
// A corner that hangs on a coarser leaf's face or edge has the value that this leaf has there, as finite elements are
// constrained: whatever it was given, the field is continuous.
#pragma once

#include "Field/CornerPlaces.h"
#include "Field/Field.h"

#include <array>
#include <bit>
#include <cstdint>

namespace treeamr
{

class CornerValues
{
  static constexpr std::array<int, 3> brickStride{ 1, 5, 25 };

  struct Brick
  {
    std::array<std::uint64_t, 2> exists{}; // corners x + 5 y + 25 z, a bit each
    std::uint64_t first = 0;               // of their values

    bool has(int corner) const noexcept { return exists[corner >> 6] >> (corner & 63) & 1; }
    /// How many there are before one.
    int rank(int corner) const noexcept
    {
      const std::uint64_t before = (std::uint64_t(1) << (corner & 63)) - 1;
      return corner < 64 ? std::popcount(exists[0] & before)
                         : std::popcount(exists[0]) + std::popcount(exists[1] & before);
    }
    int count() const noexcept { return std::popcount(exists[0]) + std::popcount(exists[1]); }
  };

public:
  /// The corners of the leaves among an inner node's children: 3 x 3 x 3 vertices.
  class Family
  {
  public:
    /// Whether such a leaf has it.
    bool has(int vertex) const noexcept { return brick_->has(corner(vertex)); }
    /// Of a vertex that is there.
    float operator[](int vertex) const noexcept { return *this->place(vertex); }
    /// Of one of its leaves.
    std::array<double, 8> corners(int octant) const noexcept
    {
      std::array<double, 8> values;
      for (int c = 0; c < 8; ++c)
      {
        values[c] = (*this)[cornerOffset(octant, familyStride) + cornerOffset(c, familyStride)];
      }
      return values;
    }

  private:
    friend class CornerValues;
    Family(const Brick& brick, const float* values, int first, int step) noexcept
      : brick_(&brick)
      , values_(values + brick.first)
      , first_(first)
      , step_(step)
    {
    }
    const float* place(int vertex) const noexcept { return values_ + brick_->rank(corner(vertex)); }
    int corner(int vertex) const noexcept
    {
      const auto [x, y, z] = placeOfCorner(vertex);
      return first_ + step_ * (brickStride[0] * x + brickStride[1] * y + brickStride[2] * z);
    }

    const Brick* brick_;
    const float* values_;
    int first_; // corner of the brick, at vertex 0
    int step_;
  };

  /// Of an octree and what `source` says of each leaf; means: of the eight corners of each leaf. Throws Error for a
  /// value that is not finite.
  CornerValues(const Octree& octree, const CornerSource& source, LargeVector<float>& means);

  /// Hull of all values; {0, 0} without cells.
  Range range() const noexcept { return range_; }
  /// The most by which leaves that share a face disagree at a corner of both, or those of a brick at one of two.
  double jump() const noexcept { return jump_; }
  /// Whether that is no more than what rounding to float and the digits of files leave. Other values are of no use.
  bool isContinuous() const noexcept { return this->isRounding(jump_); }
  /// The most by which hanging corners were given other values than they have; 0 where that is rounding.
  double hangingChange() const noexcept { return this->isRounding(hangingChange_) ? 0. : hangingChange_; }

  /// Of an inner node at a depth, and the node above it with the node's octant there (of the root: anything).
  Family family(int depth, std::uint64_t inner, std::uint64_t parent, int octant) const noexcept
  {
    if ((depth & 1) == parity_)
    {
      return Family(this->brick(depth, inner), values_.data(), 0, 2);
    }
    const int first = depth == 0 ? 0 : 2 * cornerOffset(octant, brickStride);
    return Family(this->brick(depth - 1, depth == 0 ? 0 : parent), values_.data(), first, 1);
  }
  /// Of an octree whose root is a leaf: as octant 0 of what would be above it.
  Family onlyLeaf() const noexcept { return Family(bricks_[0], values_.data(), 0, 2); }
  /// Of the inner node at an entry of the neighbourhood of a path's node at a depth.
  Family family(const TreePath& path, int depth, int entry) const noexcept;

  /// Allocated bytes.
  std::size_t byteSize() const noexcept
  {
    return values_.capacity() * sizeof(float) + bricks_.capacity() * sizeof(Brick);
  }

private:
  const Brick& brick(int depth, std::uint64_t inner) const noexcept
  {
    return bricks_[firstBrick_[depth + 1] + inner];
  }
  template <class F>
  static void forEachLeaf(const Octree& octree, int depth, std::uint64_t inner, const F& f);
  template <class F>
  void forEachBrick(const Octree& octree, const F& f);
  void markCorners(const Octree& octree);
  void fill(const Octree& octree, const CornerSource& source, LargeVector<float>& means);
  bool isRounding(double difference) const noexcept;
  template <class F>
  static double largestOfFamilies(const Octree& octree, const F& f);
  double jumpAround(const TreePath& path) const noexcept;
  struct KnownCorners;
  double constrain(const TreePath& path, KnownCorners* levels);
  double constrained(const TreePath& path, int depth, int vertex, KnownCorners* levels) const;

  int parity_;                                                   // of the bricks' depths
  std::array<std::uint64_t, Octree::maxDepth + 2> firstBrick_{}; // by 1 + depth: of inner node 0, modulo 2^64
  LargeVector<Brick> bricks_;
  LargeVector<float> values_;
  Range range_{ 0.f, 0.f };
  double jump_ = 0.;
  double hangingChange_ = 0.;
};

} // namespace treeamr
