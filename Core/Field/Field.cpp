#include "Field/Field.h"

#include "Error.h"
#include "Field/CornerValues.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_reduce.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>

namespace treeamr
{

Field::Field(std::shared_ptr<const Octree> octree, LargeVector<float> values, double offset,
  const std::optional<Range>& whole)
  : octree_(std::move(octree))
  , values_(std::move(values))
  , offset_(offset == 0. ? -0. : offset)
{
  if (!octree_)
  {
    throw Error("field: no octree, needed is the one whose leaves have the " +
      std::to_string(values_.size()) + " values");
  }
  if (values_.size() != octree_->leafCount())
  {
    throw Error("field: " + std::to_string(values_.size()) + " values for " +
      std::to_string(octree_->leafCount()) + " leaves");
  }
  if (!std::isfinite(offset_))
  {
    throw Error("field: offset " + std::to_string(offset_) + ", allowed are finite ones");
  }
  checkAndMeasureValues();
  if (whole)
  {
    range_ = values_.empty()
      ? *whole
      : Range{ std::min(range_.min, whole->min), std::max(range_.max, whole->max) };
  }
  computeMeans(range_);
}

Field Field::ofCorners(std::shared_ptr<const Octree> octree, const CornerSource& corners, double offset)
{
  if (!octree)
  {
    throw Error("field: no octree, needed is the one whose leaves have the values at corners");
  }
  LargeVector<float> means;
  auto values = std::make_shared<const CornerValues>(*octree, corners, means);
  Field field(std::move(octree), std::move(means), offset);
  if (values->isContinuous())
  {
    field.range_ = values->range();
    field.corners_ = std::move(values);
  }
  else
  {
    field.cornerJump_ = values->jump();
  }
  return field;
}

void Field::checkAndMeasureValues()
{
  struct Found
  {
    Range range{ std::numeric_limits<float>::max(), std::numeric_limits<float>::lowest() };
    std::size_t notFinite = ~std::size_t(0);
  };
  const Found found = tbb::parallel_reduce(
    tbb::blocked_range<std::size_t>(0, values_.size(), 65536), Found(),
    [&](const auto& part, Found f) {
      for (std::size_t i = part.begin(); i < part.end(); ++i)
      {
        const float v = values_[i];
        if (!std::isfinite(v))
        {
          f.notFinite = std::min(f.notFinite, i);
        }
        f.range = { std::min(f.range.min, v), std::max(f.range.max, v) };
      }
      return f;
    },
    [](const Found& a, const Found& b) {
      return Found{ { std::min(a.range.min, b.range.min), std::max(a.range.max, b.range.max) },
        std::min(a.notFinite, b.notFinite) };
    });
  if (found.notFinite < values_.size())
  {
    throw Error("field: the value of leaf " + std::to_string(found.notFinite) + " is not finite");
  }
  if (!values_.empty())
  {
    range_ = found.range;
  }
}

/// From the deepest nodes upwards. The volumes are the covered parts of nodes, 1 = all, which differ between
/// siblings where cells are missing; they are kept for two depths, and not at all while nothing is missing.
void Field::computeMeans(const Range& whole)
{
  const Octree& octree = *octree_;
  means_.resize(octree.innerCount());
  meanBase_ = whole.min > 0.f && whole.max < 2.f * whole.min ? whole.min
    : whole.max < 0.f && whole.min > 2.f * whole.max         ? whole.max
                                                             : 0.;
  LargeVector<double> volumes;
  LargeVector<double> volumesBelow;
  for (int depth = octree.innerDepths(); depth-- > 0;)
  {
    const std::uint64_t first = octree.firstInner(depth);
    const std::uint64_t end = octree.firstInner(depth + 1);
    const tbb::blocked_range<std::uint64_t> ofDepth(first, end, 4096);
    const bool whole = volumesBelow.empty() &&
      tbb::parallel_reduce(
        ofDepth, true,
        [&](const auto& nodes, bool all) {
          for (std::uint64_t n = nodes.begin(); all && n < nodes.end(); ++n)
          {
            all = octree.children(n).exists == 0xff;
          }
          return all;
        },
        std::logical_and<>());
    volumes.resize(whole ? 0 : end - first);
    tbb::parallel_for(ofDepth, [&](const auto& nodes) {
      for (std::uint64_t n = nodes.begin(); n < nodes.end(); ++n)
      {
        const Children children = octree.children(n);
        const unsigned leafCount = children.leafCount();
        double sum = 0.;
        double covered = leafCount;
        for (unsigned i = 0; i < leafCount; ++i)
        {
          sum += values_[children.firstLeaf + i] - meanBase_;
        }
        for (std::uint64_t c = children.firstInner; c < children.firstInner + children.innerCount(); ++c)
        {
          const double volume = volumesBelow.empty() ? 1. : volumesBelow[c - end];
          sum += volume * means_[c];
          covered += volume;
        }
        means_[n] = static_cast<float>(sum / covered);
        if (!whole)
        {
          volumes[n - first] = covered / 8.;
        }
      }
    });
    std::swap(volumes, volumesBelow);
  }
}

const NodeRanges& Field::nodeRanges() const
{
  const std::scoped_lock lock(ranges_->mutex);
  if (!ranges_->made)
  {
    // Without isolation this thread, waiting for its workers, could start a task of somebody else that asks for the
    // same and would wait for the lock that this thread holds.
    tbb::this_task_arena::isolate([&] { ranges_->made = std::make_unique<const NodeRanges>(*this); });
  }
  return *ranges_->made;
}

std::size_t Field::byteSize() const
{
  const std::scoped_lock lock(ranges_->mutex);
  return (values_.capacity() + means_.capacity()) * sizeof(float) +
    (ranges_->made ? ranges_->made->byteSize() : 0) + (corners_ ? corners_->byteSize() : 0);
}

const Field& required(const std::shared_ptr<const Field>& field, const char* user)
{
  if (!field)
  {
    throw Error(std::string(user) + ": no field (a null pointer)");
  }
  return *field;
}

} // namespace treeamr
