// What a frame of a volume is asked for, and what it did.
#pragma once

#include "Field/RangeCode.h"
#include "Geometry/Camera.h"
#include "Geometry/Light.h"
#include "Geometry/RayStops.h"

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace treeamr
{

/// A ray with less light left than this is done: a quarter of what an 8-bit channel shows.
inline constexpr float opaqueTransmittance = 1.f / 1024.f;

/// What a ray makes of the values along it.
enum class VolumeBlend
{
  Composite, // emission and absorption, front to back
  Maximum,   // the largest value, in its colour and its opacity
  Minimum,   // the smallest one
  Average, // mean over the ray's length of opacity times value, the values' range taken as 0 to 1: an opaque grey
  Additive, // integral of opacity times value over lengths in unit distances, in the same way
  Slice     // where it meets a plane alone: the value's colour and its opacity over the unit distance
};

/// Whether it makes numbers of what is along a ray, rather than light.
constexpr bool blendsValues(VolumeBlend blend) noexcept
{
  return blend != VolumeBlend::Composite && blend != VolumeBlend::Slice;
}

/// What a volume scatters of the light of all of its lights, wherever its gradient points: in place of some of what it
/// reflects, and dimmed by what lies on the way from the light. As of VTK's GPU mapper (its VolumetricScatteringBlending
/// and GlobalIlluminationReach).
struct VolumeScattering
{
  /// Above 0, at most 2. Up to 1: the part of light that is scattered where little is opaque, and less of what is; from
  /// there to 2, all.
  float blending = 2.f;
  /// Longest way towards a light that dims it, where the domain is a cube of width 1.
  double reach = 2.;
  /// Of Henyey and Greenstein's phase function, above -1 and below 1: more forward where it is positive.
  float anisotropy = 0.f;
  /// In the world, over which the blending counts opacities.
  double sampleLength = 1.;
};

/// How a volume reflects light: at each sample by the field's gradient there, which is continuous where cells of
/// different sizes meet. Where the field is flat there is the ambient term alone.
struct VolumeShading
{
  float ambient = 0.1f;                // of the sample's colour
  float diffuse = 0.7f;                // likewise
  float specular = 0.2f;               // of the light's colour
  float specularPower = 10.f;          // larger ones make highlights smaller
  std::array<float, 3> ambientLight{}; // as it is, whatever the sample's colour
  /// In coordinates whose origin is the eye. With none there are the ambient terms alone.
  std::vector<Light> lights;
  Matrix4 lightsFromData{ 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1. }; // affine
  /// Whether light also falls on sides whose values fall the way it travels.
  bool twoSided = true;
  std::optional<VolumeScattering> scattering{}; // none: all of the light is reflected
};

/// By which a sample's extinction is multiplied: a function of the length of the gradient, per unit of data
/// coordinates.
struct GradientOpacity
{
  double longest = 1.; // gradient, above 0
  /// Two or more in [0, 1], equally spaced from no gradient to the longest: linear in between, constant beyond.
  std::vector<float> entries;

  bool operator==(const GradientOpacity&) const = default;
};

/// Of a frame.
struct VolumeSettings
{
  /// Samples along a cell's width, up to the maximum, where the transfer function varies in the cell; fewer
  /// where little can change, but one at least for each cell or block of eight that a ray crosses.
  double samplesPerCell = 2.;
  static constexpr double maxSamplesPerCell = 1e6; // what is allowed
  /// Leave out nodes whose range is transparent. Never changes a pixel; off only to test that.
  bool skipEmpty = true;
  /// Integrate over the values between samples where points would miss too much of the transfer function; off only
  /// to measure that.
  bool preIntegration = true;
  /// Of its light that a ray may have left when it ends, above 0 and below 1; less only to measure what that leaves out.
  float leastTransmittance = opaqueTransmittance;
  /// Count in doubles where floats would do, too; on only to test that.
  bool doubles = false;
  /// Nodes whose children are smaller than this many pixels may be drawn from their means; 0 is off.
  double levelOfDetailPixels = 0.;
  /// Each leaf shows its own value everywhere in it, and its centre's gradient: nothing is reconstructed in between.
  bool nearest = false;
  VolumeBlend blend = VolumeBlend::Composite; // what is made of the values
  /// Length in the world over which the opacities count that blends other than composite ask for.
  double unitDistance = 1.;
  /// Whose face a slice is.
  HalfSpace slice{};
  /// Values, less the field's offset, that an average counts.
  Range averageRange{ -std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity() };
  /// Of composites and slices; not of categories, which have no gradients.
  std::optional<VolumeShading> shading{};
  std::optional<GradientOpacity> gradientOpacity{}; // likewise
  /// Of the second and further components of a volume, which are lit where it is: coefficients in place of those of
  /// `shading`, which components have that are not here.
  std::vector<VolumeShading> componentShading{};
};

/// Counts of a frame.
struct VolumeStatistics
{
  std::uint64_t rays = 0;          // that had a part of the view to themselves
  std::uint64_t nodes = 0;         // inner nodes entered
  std::uint64_t kept = 0;          // blocks of leaves whose vertex values were found
  std::uint64_t blocks = 0;        // that were computed
  std::uint64_t cells = 0;         // leaves in these
  std::uint64_t keptGradients = 0; // blocks whose vertex gradients were found
  std::uint64_t gradients = 0;     // that were computed
  std::uint64_t keptColors = 0;    // blocks of a field that colours whose vertex values were found
  std::uint64_t colors = 0;        // that were computed
  std::uint64_t intervals = 0;     // vectors of rays taken through a leaf or block
  std::uint64_t steps = 0;         // of these vectors
  std::uint64_t litSteps = 0;      // that were not transparent for all of their rays
  std::uint64_t samples = 0;       // of the field along rays

  /// Of both together.
  VolumeStatistics& operator+=(const VolumeStatistics& other) noexcept
  {
    rays += other.rays;
    nodes += other.nodes;
    kept += other.kept;
    blocks += other.blocks;
    cells += other.cells;
    keptGradients += other.keptGradients;
    gradients += other.gradients;
    keptColors += other.keptColors;
    colors += other.colors;
    intervals += other.intervals;
    steps += other.steps;
    litSteps += other.litSteps;
    samples += other.samples;
    return *this;
  }
};

} // namespace treeamr
