// What shines on surfaces and volumes.
#pragma once

#include "Geometry/Vec3.h"

#include <array>

namespace treeamr
{

/// In the coordinates of the points that it shines on.
struct Light
{
  bool positional = false;                     // shines from its position, rather than from afar
  Vec3 position{};                             // positional only
  Vec3 direction{};                            // the way the light travels, unit length
  double coneAngle = 180.;                     // half angle in degrees; >= 90: no cone; positional only
  double exponent = 1.;                        // of the cosine to the cone's axis; positional only
  Vec3 attenuation{ 1., 0., 0. };              // constant, linear, quadratic
  std::array<float, 3> color{ 1.f, 1.f, 1.f }; // times intensity
  std::array<float, 3> specularColor{ 1.f, 1.f, 1.f }; // the same, of highlights in volumes
  bool castsShadows = true;                            // where shadows are asked for
  /// Whether the highlight depends on the angle between the light and the normal, as VTK has it for a headlight alone,
  /// rather than on that between the mirrored light and the eye: it is larger then.
  bool highlightByCosine = false;

  bool operator==(const Light&) const = default;
};

} // namespace treeamr
