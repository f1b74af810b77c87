#include "Volume/Kernel/VolumeKernel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace treeamr
{

VolumeKernelScene::VolumeKernelScene(const Field& field, const TransferFunction& transferFunction,
  const VolumeTable& table, const RayView& view, const VolumeSettings& settings, BlockCache& kept,
  Image* image)
  : field(field)
  , transferFunction(transferFunction)
  , table(table)
  , camera(view.camera)
  , stops(view.stops)
  , settings(settings)
  , kept(kept)
  , image(image)
  , ranges(settings.skipEmpty ? &field.nodeRanges() : nullptr)
{
  place();
  measurePixels();
  features.doubles = settings.doubles || !table.fitsSinglePrecision || !resolves();
  features.categories = transferFunction.hasCategories();
  if (!features.categories && settings.preIntegration)
  {
    const double width = static_cast<double>(field.range().max) - field.range().min;
    const HullTerms all{ table.variation.back(), table.curvature.back(),
      std::max<double>(table.last, width * transferFunction.scale() * table.perEntry) };
    features.preIntegration = !transferFunction.nodes().empty() || table.rough.back() > 0 ||
      !pointsSuffice(*this, all, relativeLeafWidth(field.octree().grid(), 0));
  }
}

/// Whether single precision tells neighbouring rays from each other, and the two sides of the domain: not so in far
/// zooms that move the picture but not the eye, nor in domains as thin as a sheet.
bool VolumeKernelScene::resolves() const
{
  const Bounds domain = field.octree().grid().bounds();
  double squared = 0.; // of the way from the reference to the domain's middle
  double thickness = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a)
  {
    squared += std::pow(0.5 * (domain.min[a] + domain.max[a]) - reference[a], 2);
    thickness = std::min(thickness, domain.max[a] - domain.min[a]);
  }
  constexpr double rounding = 0x1p-24;
  const double farthest = dataScale * std::sqrt(squared) + 0.5; // the diagonal is 1
  // Of rays from one point pixels and roundings grow alike on the way.
  const double pixel = features.commonOrigin ? pixelGrowth : pixelWidth / farthest;
  constexpr double parts = 16.;
  constexpr double thicknessParts = 256.;
  return pixel > parts * rounding && dataScale * thickness > thicknessParts * rounding * farthest;
}

/// Where the kernel counts from, and in which units.
void VolumeKernelScene::place()
{
  const Bounds domain = field.octree().grid().bounds();
  const Ray central = camera.ray(camera.width() / 2, camera.height() / 2);
  direction = central.direction;
  double toCentre = 0.; // in t
  for (int a = 0; a < 3; ++a)
  {
    toCentre += (0.5 * (domain.min[a] + domain.max[a]) - central.origin[a]) * direction[a];
  }
  const double squared = dot(direction, direction);
  toCentre /= squared;
  dataScale = 1. / diagonalOf(domain);
  const double diagonal = diagonalOf(domain) / std::sqrt(squared); // in t
  // Far away (narrow angles), counting from the eye would leave the domain to the last digits: from its middle then.
  constexpr double nearby = 8.;
  scale = 1. / diagonal;
  features.commonOrigin = camera.isPerspective() && std::abs(toCentre) < nearby * diagonal;
  tReference = features.commonOrigin ? 0. : toCentre;
  for (int a = 0; a < 3; ++a)
  {
    reference[a] = central.origin[a] + tReference * direction[a];
  }
  if (features.commonOrigin)
  {
    fan = camera.fan();
  }
}

/// Widths of pixels from the distance between two rays in the image's middle.
void VolumeKernelScene::measurePixels()
{
  const int x = camera.width() / 2;
  const int y = camera.height() / 2;
  const Ray a = camera.ray(x, y);
  const Ray b = camera.ray(x + 1, y);
  double origins = 0.;
  double directions = 0.;
  for (int i = 0; i < 3; ++i)
  {
    origins += std::pow(b.origin[i] - a.origin[i], 2);
    directions += std::pow(b.direction[i] - a.direction[i], 2);
  }
  const double growth = dataScale * std::sqrt(directions); // per t
  pixelWidth = dataScale * std::sqrt(origins) + tReference * growth;
  pixelGrowth = growth / scale;
}

} // namespace treeamr
