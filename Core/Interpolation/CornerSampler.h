// Values and gradients at points of a field that is given at corners: what a Sampler of it asks in each of its threads.
#pragma once

#include "Field/CornerValues.h"
#include "Interpolation/LeafFinder.h"
#include "Interpolation/Sampler.h"

namespace treeamr
{

/// Of one field, which must live as long, for one thread.
class CornerSampler
{
public:
  explicit CornerSampler(const Field& field) noexcept;

  /// As Sampler::sampleRelative().
  bool sample(const Vec3& pWorld, FieldSample& sample) noexcept;

private:
  const CornerValues& corners_;
  const Octree& octree_;
  LeafFinder leaves_;
};

} // namespace treeamr
