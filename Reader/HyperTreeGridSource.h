// What buildOctree() asks of a vtkHyperTreeGrid: its nodes top-down and the values of one array. Private to
// the converter.
#pragma once

#include "ContentDigest.h"
#include "CornerArrays.h"
#include "HyperTreeGridConverter.h"
#include "HyperTreeGridTopology.h"
#include "WholeRange.h"

#include "Octree/OctreeBuilder.h"

#include "vtkAOSDataArrayTemplate.h"
#include "vtkDataArray.h"
#include "vtkVariant.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>

namespace treeamr
{

/// A component or the magnitude of a cell array, by global index; of one of values at corners their mean.
class CellValues
{
public:
  /// Throws Error as numericCellArray(), and when the array has no such component or fewer than `indexEnd` tuples.
  CellValues(vtkHyperTreeGrid& grid, const ArraySelection& selection, vtkIdType indexEnd)
  {
    array_ = &numericCellArray(grid, selection.name);
    const std::string name = "hyper tree grid: cell array '" + selection.name + "' ";
    componentCount_ = array_->GetNumberOfComponents();
    isAtCorners_ = treeamr::isAtCorners(*array_);
    if (selection.component >= componentCount_)
    {
      throw Error(name + "has no component " + std::to_string(selection.component) + ", allowed are 0 to " +
        std::to_string(componentCount_ - 1) + " and negative for the magnitude");
    }
    component_ = isAtCorners_ ? -1 : componentCount_ == 1 ? 0 : std::max(selection.component, -1);
    wholeRange_ = treeamr::wholeRange(grid, selection.name, component_);
    if (array_->GetNumberOfTuples() < indexEnd)
    {
      throw Error(name + "has " + std::to_string(array_->GetNumberOfTuples()) + " tuples, the cells need " +
        std::to_string(indexEnd));
    }
    if (auto* doubles = vtkAOSDataArrayTemplate<double>::FastDownCast(array_))
    {
      doubles_ = doubles->GetPointer(0);
    }
    else if (auto* floats = vtkAOSDataArrayTemplate<float>::FastDownCast(array_))
    {
      floats_ = floats->GetPointer(0);
    }
    else if (this->hasLongIntegers() && array_->HasStandardMemoryLayout())
    {
      longs_ = static_cast<const unsigned char*>(array_->GetVoidPointer(0));
    }
  }

  double operator()(vtkIdType index) const
  {
    if (component_ >= 0)
    {
      return this->at(index, component_);
    }
    if (isAtCorners_)
    {
      double sum = 0.;
      for (int c = 0; c < cornerCount; ++c)
      {
        sum += this->at(index, c) / cornerCount; // without an overflow
      }
      return sum;
    }
    double squares = 0.;
    for (int c = 0; c < componentCount_; ++c)
    {
      const double v = array_->GetComponent(index, c);
      squares += v * v;
    }
    return std::sqrt(squares);
  }
  /// less(index, 0.) without what double rounds off: 64-bit integers are subtracted as such, if only their distance
  /// from the offset is below 2^63.
  double less(vtkIdType index, double offset) const
  {
    if (component_ < 0 || !this->hasLongIntegers())
    {
      return (*this)(index)-offset;
    }
    const double whole = std::floor(offset);
    const std::uint64_t difference = this->bits(index * componentCount_ + component_) - bitsOf(whole);
    return static_cast<double>(static_cast<std::int64_t>(difference)) - (offset - whole);
  }
  bool isFinite(vtkIdType index) const
  {
    constexpr double most = std::numeric_limits<float>::max();
    bool areFinite = true;
    for (int c = 0; c < cornerCount && isAtCorners_; ++c)
    {
      areFinite = areFinite && std::abs(this->at(index, c)) <= most;
    }
    return areFinite && std::abs((*this)(index)) <= most;
  }
  bool isAtCorners() const noexcept { return isAtCorners_; }
  /// At a corner of the grid's own axes.
  double corner(vtkIdType index, int corner) const { return this->at(index, corner); }

  /// Of all values of the array and their type.
  ContentDigest digest() const
  {
    ContentDigest digest;
    digest.add(std::uint64_t(array_->GetDataType()));
    digest.add(std::uint64_t(componentCount_));
    digest.add(std::uint64_t(isAtCorners_));
    if (wholeRange_)
    {
      digest.add((*wholeRange_)[0]);
      digest.add((*wholeRange_)[1]);
    }
    const vtkIdType count = array_->GetNumberOfValues();
    if (array_->HasStandardMemoryLayout() && array_->GetDataType() != VTK_BIT)
    {
      digest.addBytes(array_->GetVoidPointer(0), static_cast<std::size_t>(count) * array_->GetDataTypeSize());
      return digest;
    }
    for (vtkIdType i = 0; i < count; ++i)
    {
      if (this->hasLongIntegers())
      {
        digest.add(this->bits(i));
        continue;
      }
      digest.add(array_->GetComponent(i / componentCount_, static_cast<int>(i % componentCount_)));
    }
    return digest;
  }

  /// Of what other processes hold, too, as floats less an offset; none: nobody has agreed on one.
  std::optional<Range> wholeRange(double offset) const
  {
    return wholeRange_ && !isAtCorners_ ? std::optional(Range{ static_cast<float>((*wholeRange_)[0] - offset),
                                            static_cast<float>((*wholeRange_)[1] - offset) })
                                        : std::nullopt;
  }

  vtkDataArray& array() const noexcept { return *array_; }
  /// Negative: the magnitude, or of values at corners the mean.
  int component() const noexcept { return component_; }

  /// The mean.
  class Blend
  {
  public:
    void add(double value, double weight)
    {
      sum_ += weight * value;
      weight_ += weight;
    }
    double value() const { return sum_ / weight_; }

  private:
    double sum_ = 0.;
    double weight_ = 0.;
  };

private:
  double at(vtkIdType index, int component) const
  {
    const vtkIdType place = index * componentCount_ + component;
    // GetComponent(): other than GetTuple(i) it uses no buffer of the array.
    return doubles_ ? doubles_[place] : floats_ ? floats_[place] : array_->GetComponent(index, component);
  }
  bool hasLongIntegers() const
  {
    return array_->GetDataTypeSize() == sizeof(std::uint64_t) && array_->GetDataType() != VTK_DOUBLE;
  }
  /// Of such an array's value, signed or not: differences modulo 2^64 are the same.
  std::uint64_t bits(vtkIdType at) const
  {
    if (longs_)
    {
      std::uint64_t bits;
      std::memcpy(&bits, longs_ + at * sizeof(bits), sizeof(bits));
      return bits;
    }
    const vtkVariant value = array_->GetVariantValue(at);
    return array_->GetDataTypeMin() < 0. ? static_cast<std::uint64_t>(value.ToTypeInt64())
                                         : value.ToTypeUInt64();
  }
  /// Of a whole number from -2^63 to 2^64, which counts as 0.
  static std::uint64_t bitsOf(double whole)
  {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(whole < 0x1p63 ? whole : whole - 0x1p64));
  }

  vtkDataArray* array_ = nullptr;
  const double* doubles_ = nullptr; // the array's memory when it is of this type
  const float* floats_ = nullptr;
  const unsigned char* longs_ = nullptr; // of 64-bit integers
  int componentCount_ = 0;
  int component_ = 0;
  bool isAtCorners_ = false;
  std::optional<std::array<double, 2>> wholeRange_;
};

/// The same less an offset. Keeps a reference to the values.
class RelativeValues
{
public:
  RelativeValues(const CellValues& values, double offset)
    : values_(values)
    , offset_(offset)
  {
  }
  double operator()(vtkIdType index) const { return values_.less(index, offset_); }
  using Blend = CellValues::Blend;

private:
  const CellValues& values_;
  double offset_;
};

/// For an octree alone.
struct NoValues
{
  struct Blend
  {
    void add(double /*value*/, double /*weight*/) {}
    double value() const { return 0.; }
  };
  double operator()(vtkIdType /*index*/) const { return 0.; }
};

/// A Source as OctreeBuilder.h describes it. Keeps references to both arguments. Values: CellValues or like these.
template <class Values>
class HyperTreeGridSource
{
public:
  struct Handle
  {
    std::uint32_t tree;   // in the order of the topology
    std::uint32_t vertex; // VTK's trees count their vertices in 32 bits
    std::uint32_t level;
  };

  HyperTreeGridSource(const HyperTreeGridTopology& topology, const Values& values)
    : topology_(topology)
    , values_(values)
  {
  }

  std::size_t rootCount() const noexcept { return topology_.trees().size(); }
  std::array<Coord, 3> rootPlace(std::size_t tree) const { return topology_.trees()[tree].root; }
  Handle root(std::size_t tree) const { return { static_cast<std::uint32_t>(tree), 0, 0 }; }

  NodeKind kind(const Handle& handle) const
  {
    const HyperTreeView& tree = topology_.trees()[handle.tree];
    if (!topology_.exists(tree, handle.vertex))
    {
      return NodeKind::None;
    }
    return isLeaf(tree, handle) ? NodeKind::Leaf : NodeKind::Inner;
  }

  Handle child(const Handle& handle, int octant) const
  {
    const vtkIdType vertex = topology_.trees()[handle.tree].child(handle.vertex, octant);
    return { handle.tree, static_cast<std::uint32_t>(vertex), handle.level + 1 };
  }

  /// At the depth limit the leaves below, by volume: coarse vertices may hold anything.
  float value(const Handle& handle) const
  {
    const HyperTreeView& tree = topology_.trees()[handle.tree];
    if (tree.isLeaf(handle.vertex))
    {
      return static_cast<float>(values_(tree.globalIndex(handle.vertex)));
    }
    typename Values::Blend blend;
    addLeaves(tree, handle.vertex, handle.level, 1., blend);
    return static_cast<float>(blend.value());
  }

  /// Of a leaf, less an offset, of values at corners. At the depth limit those of the leaves in the corners, or the mean of
  /// all where one of these is missing.
  std::array<float, 8> corners(const Handle& handle, double offset) const
  {
    const HyperTreeView& tree = topology_.trees()[handle.tree];
    std::array<float, 8> values;
    for (int corner = 0; corner < cornerCount; ++corner)
    {
      vtkIdType vertex = handle.vertex;
      for (unsigned int level = handle.level; topology_.exists(tree, vertex) && !tree.isLeaf(vertex); ++level)
      {
        topology_.checkDepth(level);
        vertex = tree.child(vertex, corner);
      }
      values[corner] = topology_.exists(tree, vertex)
        ? static_cast<float>(values_.corner(tree.globalIndex(vertex), corner ^ tree.turned) - offset)
        : static_cast<float>(value(handle) - offset);
    }
    return values;
  }

  bool ghosts() const noexcept { return topology_.hasGhosts() && !topology_.isPartitioned(); }
  bool isGhost(const Handle& handle) const noexcept
  {
    return topology_.isGhost(topology_.trees()[handle.tree], handle.vertex);
  }

private:
  bool isLeaf(const HyperTreeView& tree, const Handle& handle) const noexcept
  {
    return handle.level >= topology_.depthLimit() || tree.isLeaf(handle.vertex);
  }

  void addLeaves(const HyperTreeView& tree, vtkIdType vertex, unsigned int level, double weight,
    typename Values::Blend& blend) const
  {
    if (!topology_.exists(tree, vertex))
    {
      return;
    }
    if (tree.isLeaf(vertex))
    {
      blend.add(values_(tree.globalIndex(vertex)), weight);
      return;
    }
    topology_.checkDepth(level); // bounds the recursion
    for (int o = 0; o < 8; ++o)
    {
      addLeaves(tree, tree.firstChild(vertex) + o, level + 1, weight / 8., blend);
    }
  }

  const HyperTreeGridTopology& topology_;
  const Values& values_;
};

} // namespace treeamr
