// The light of one sample of a volume, as VTK's volume mapper defines it: straight from its formulas, in doubles.
#pragma once

#include "Volume/VolumeSettings.h"

#include <array>

namespace treeamr::test
{

/// The function at the length of a gradient, linear between entries.
double gradientOpacity(const GradientOpacity& function, const Vec3& gradient);

/// point and gradient: in data coordinates.
std::array<double, 3> lightVolume(
  const VolumeShading& shading, const Vec3& point, const Vec3& gradient, const std::array<double, 3>& color);

} // namespace treeamr::test
