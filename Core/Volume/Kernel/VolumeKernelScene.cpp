#include "Volume/Kernel/VolumeKernel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace treeamr
{

VolumeLoop volumeLoop(const VolumeSettings& settings, bool hasCategories) noexcept
{
  switch (settings.blend)
  {
    case VolumeBlend::Maximum:
    case VolumeBlend::Minimum:
      return VolumeLoop::Extreme;
    case VolumeBlend::Average:
    case VolumeBlend::Additive:
      return VolumeLoop::Sum;
    case VolumeBlend::Slice:
      return VolumeLoop::Lit;
    default:
      return usesGradients(settings, hasCategories) ? VolumeLoop::Lit : VolumeLoop::Plain;
  }
}

bool usesGradients(const VolumeSettings& settings, bool hasCategories) noexcept
{
  return !blendsValues(settings.blend) && !hasCategories && (settings.shading || settings.gradientOpacity);
}

VolumeIllumination::VolumeIllumination(const VolumeSettings& settings, const VolumeKernelScene& scene)
  : usesGradients(scene.gradients)
  , shades(usesGradients && settings.shading)
  , gradientOpacity(nullptr)
{
  if (usesGradients && settings.gradientOpacity)
  {
    const GradientOpacity& function = *settings.gradientOpacity;
    gradientOpacity = function.entries.data();
    lastEntry = static_cast<double>(function.entries.size() - 1);
    const double perGradient = scene.gradients->scale();
    entriesPerLength = perGradient > 0. ? lastEntry / (function.longest * perGradient) : 0.;
    const auto visible =
      std::find_if(function.entries.begin(), function.entries.end(), [](float entry) { return entry > 0.f; });
    const auto hidden = static_cast<double>(visible - function.entries.begin());
    hiddenLength = visible == function.entries.end() ? std::numeric_limits<double>::infinity()
      : hidden > 0. && entriesPerLength > 0.         ? (hidden - 1.) / entriesPerLength
                                                     : -1.;
    if (!settings.shading && entriesPerLength > 0.)
    {
      const float before = *(function.entries.end() - 2);
      ofLong = before + (function.entries.back() - before); // as samples have it
      const auto other = std::find_if(function.entries.rbegin(), function.entries.rend(),
        [&](float entry) { return entry != function.entries.back(); });
      longLength = static_cast<double>(function.entries.rend() - other) / entriesPerLength;
    }
  }
  if (shades)
  {
    place(*settings.shading, scene);
  }
}

void VolumeIllumination::place(const VolumeShading& shading, const VolumeKernelScene& scene)
{
  twoSided = shading.twoSided;
  ambient = shading.ambient;
  ofHighlights = Falloff(shading.specularPower);
  std::copy_n(shading.ambientLight.begin(), 3, ambientLight.begin());
  const Matrix4& m = shading.lightsFromData;
  std::array<Vec3, 3> rows; // of directions
  unit = 0.; // a kernel unit's length in the lights' coordinates
  for (int r = 0; r < 3; ++r)
  {
    rows[r] = { m[4 * r], m[4 * r + 1], m[4 * r + 2] };
    unit = std::max(unit, std::sqrt(dot(rows[r], rows[r])) / scene.dataScale);
  }
  unit = unit > 0. ? unit : 1.; // a matrix of zeros takes all to the eye
  const auto inUnits = [&](int r, const Vec3& point) { return (dot(rows[r], point) + m[4 * r + 3]) / unit; };
  std::array<Vec3, 3> directions;
  for (int r = 0; r < 3; ++r)
  {
    for (int a = 0; a < 3; ++a)
    {
      directions[r][a] = viewFromKernel[r][a] = rows[r][a] / scene.dataScale / unit;
    }
    viewFromKernel[r][3] = inUnits(r, scene.reference);
  }
  // The inverse transpose, up to a positive factor: a mirrored volume keeps its sides.
  const double side = dot(directions[0], cross(directions[1], directions[2])) < 0. ? -1. : 1.;
  for (int r = 0; r < 3; ++r)
  {
    normalFromGradient[r] = cross(directions[(r + 1) % 3], directions[(r + 2) % 3]);
  }
  double largest = 0.;
  for (const Vec3& row : normalFromGradient)
  {
    largest = std::max({ largest, std::abs(row[0]), std::abs(row[1]), std::abs(row[2]) });
  }
  for (Vec3& row : normalFromGradient)
  {
    for (double& component : row)
    {
      component = largest > 0. ? side * component / largest : 0.;
    }
  }
  const Ray central = scene.camera.ray(scene.camera.width() / 2, scene.camera.height() / 2);
  double fromOrigin = 0.; // of the eye, where the lights' coordinates have it
  for (int r = 0; r < 3; ++r)
  {
    fromOrigin = std::max(fromOrigin, std::abs(inUnits(r, central.origin)));
  }
  constexpr double rounding = 1e-6;
  seesAlongRays = scene.camera.isPerspective() && fromOrigin < rounding;
  addLights(shading);
  needsPoints = !seesAlongRays || std::any_of(lights.begin(), lights.end(), [](const KernelLight& light) {
    return !light.isAtEye && light.isPositional;
  });
}

void VolumeIllumination::addLights(const VolumeShading& shading)
{
  for (const Light& from : shading.lights)
  {
    KernelLight light{};
    light.isPositional = from.positional;
    light.isCone = from.positional && from.coneAngle < 90.;
    light.direction = from.direction;
    light.coneCosine = std::cos(from.coneAngle * std::numbers::pi / 180.);
    light.inCone = Falloff(from.exponent);
    light.attenuation = { from.attenuation[0], from.attenuation[1] * unit,
      from.attenuation[2] * unit * unit };
    light.isAtEye =
      from.positional && !light.isCone && from.position == Vec3{} && from.attenuation == Vec3{ 1., 0., 0. };
    bool shinesOn = false;
    for (int c = 0; c < 3; ++c)
    {
      light.position[c] = from.position[c] / unit;
      light.diffuse[c] = shading.diffuse * from.color[c];
      light.specular[c] = shading.specular * from.specularColor[c];
      shines = shines || light.specular[c] != 0.;
      shinesOn = shinesOn || light.diffuse[c] != 0. || light.specular[c] != 0.;
    }
    if (shinesOn)
    {
      lights.push_back(light);
    }
  }
}

std::vector<ShadowLattice::Source> VolumeIllumination::sources(const Matrix4& m) const
{
  const std::array<Vec3, 3> rows{ Vec3{ m[0], m[1], m[2] }, { m[4], m[5], m[6] }, { m[8], m[9], m[10] } };
  std::array<Vec3, 3> columns; // of the inverse, times the determinant
  for (int r = 0; r < 3; ++r)
  {
    columns[r] = cross(rows[(r + 1) % 3], rows[(r + 2) % 3]);
  }
  const double volume = dot(rows[0], columns[0]);
  std::vector<ShadowLattice::Source> result;
  if (!(std::abs(volume) > 0.))
  {
    return result;
  }
  for (const KernelLight& light : lights)
  {
    ShadowLattice::Source source{ light.isPositional, {} };
    for (int r = 0; r < 3; ++r)
    {
      const double component = light.isPositional ? light.position[r] * unit - m[4 * r + 3] : light.direction[r];
      for (int a = 0; a < 3; ++a)
      {
        source.place[a] += columns[r][a] * component / volume;
      }
    }
    result.push_back(source);
  }
  return result;
}

void VolumeIllumination::scatter(
  const VolumeScattering& wanted, const ShadowLattice& shadows, const VolumeKernelScene& scene)
{
  KernelScattering kernel{};
  kernel.blending = 0.5 * wanted.blending;
  kernel.depthPerExtinction = wanted.sampleLength / diagonalOf(scene.field.octree().grid().bounds());
  kernel.anisotropy = wanted.anisotropy;
  kernel.nodes = shadows.nodes();
  for (int a = 0; a < 3; ++a)
  {
    kernel.cellsPerUnit[a] = 1. / (scene.dataScale * shadows.cell()[a]);
    kernel.reference[a] = (scene.reference[a] - shadows.origin()[a]) / shadows.cell()[a];
  }
  scattering = kernel;
  for (std::size_t i = 0; i < lights.size() && shadows.lights() == lights.size(); ++i)
  {
    lights[i].transmittance = shadows.transmittance(i);
  }
}

namespace
{

/// Whether cells may have faces in a plane.
bool hasFaces(const HalfSpace& plane, const Octree& octree)
{
  const RootGrid& grid = octree.grid();
  constexpr double unresolved = 0x1p-17; // by single precision, along ways of about the domain's diagonal
  const double least = unresolved * diagonalOf(grid.bounds());
  for (int a = 0; a < 3; ++a)
  {
    if (plane.normal[(a + 1) % 3] != 0. || plane.normal[(a + 2) % 3] != 0.)
    {
      continue;
    }
    const double place = plane.offset / plane.normal[a];
    const double inCells = std::ldexp(grid.latticeCoordinate(a, place), octree.leafLevels());
    if (!(inCells >= 0.))
    {
      return false;
    }
    const auto nearest = static_cast<Coord>(std::llround(inCells));
    return std::abs(grid.worldPlane(a, nearest, octree.leafLevels()) - place) < least;
  }
  return false;
}

} // namespace

VolumeKernelScene::VolumeKernelScene(const Field& field, const TransferFunction& transferFunction,
  const VolumeTable& table, const RayView& view, const VolumeSettings& settings, BlockCache& kept,
  GradientCache* gradients, Image* image)
  : field(field)
  , transferFunction(transferFunction)
  , table(table)
  , camera(view.camera)
  , stops(view.stops)
  , settings(settings)
  , kept(kept)
  , gradients(gradients)
  , ofGradients(&field)
  , image(image)
  , ranges(settings.skipEmpty ? &field.nodeRanges() : nullptr)
{
  place();
  measurePixels();
  features.doubles = settings.doubles || !table.fitsSinglePrecision || !resolves();
  const bool hasCategories = transferFunction.hasCategories();
  features.constants = hasCategories || settings.nearest;
  features.means = settings.levelOfDetailPixels > 0. && !hasCategories;
  features.slices = settings.blend == VolumeBlend::Slice;
  features.slicesFaces = features.slices && hasFaces(settings.slice, field.octree());
  features.loop = volumeLoop(settings, hasCategories);
  const double width = static_cast<double>(field.range().max) - field.range().min;
  const bool isMinimum = settings.blend == VolumeBlend::Minimum;
  placeOrigin = isMinimum ? field.range().max : field.range().min;
  perValue = width > 0. ? (isMinimum ? -1. : 1.) / width : 0.;
  unitDepth = std::min(settings.unitDistance / diagonalOf(field.octree().grid().bounds()), farthestPlace);
  if (features.slices)
  {
    partOfFinestStep =
      std::min(1., relativeLeafWidth(field.octree().grid(), field.octree().leafLevels()) / unitDepth);
  }
  if (gradients || features.slices)
  {
    illumination.emplace(settings, *this);
  }
  if (!blendsValues(settings.blend) && !features.constants && settings.preIntegration)
  {
    const HullTerms all{ table.variation.back(), table.curvature.back(),
      std::max<double>(table.last, width * transferFunction.scale() * table.perEntry) };
    features.preIntegration = features.slices || !transferFunction.nodes().empty() ||
      table.rough.back() > 0 || !pointsSuffice(*this, all, relativeLeafWidth(field.octree().grid(), 0));
  }
}

void VolumeKernelScene::mix(KernelMixture others)
{
  mixture = std::move(others);
  features.loop = VolumeLoop::Lit;
  for (const auto& part : mixture->parts)
  {
    features.doubles = features.doubles || part->features.doubles;
  }
  if (mixture->mixing == VolumeMixing::Independent)
  {
    // Seen is what any of them shows, and by points.
    ranges = nullptr;
    features.preIntegration = false;
  }
  if (!illumination)
  {
    illumination.emplace(settings, *this);
  }
  if (mixture->table)
  {
    placeTable();
  }
}

KernelTable2D::KernelTable2D(const TransferFunction2D& made, double diagonal, bool byGradient)
  : function(made.withExtinctionsTimes(diagonal * std::numbers::log2e))
  , byGradient(byGradient)
{
  const TransferFunction2D::Axis& axis = function.second();
  const std::vector<TransferFunction::Entry> most = function.mostOverSecond().entries();
  const auto visible =
    std::find_if(most.begin(), most.end(), [](const auto& entry) { return entry.extinction > 0.f; });
  const auto row = static_cast<double>(visible - most.begin());
  const double width = (axis.max - axis.min) / static_cast<double>(axis.size - 1);
  hidden = visible == most.end() ? std::numeric_limits<double>::infinity()
    : row > 0.                   ? axis.min + (row - 1.) * width
                                 : -std::numeric_limits<double>::infinity();
}

/// By points, in place of gradient opacity.
void VolumeKernelScene::placeTable()
{
  features.preIntegration = false;
  const TransferFunction2D::Axis& axis = mixture->table->function.second();
  const double width = axis.max - axis.min;
  const double rows = width > 0. ? static_cast<double>(axis.size - 1) / width : 0.;
  mixture->columnsPerPlace = 1. / table.perEntry;
  illumination->gradientOpacity = nullptr;
  illumination->longLength = std::numeric_limits<double>::infinity();
  illumination->hiddenLength = -1.;
  if (mixture->table->byGradient)
  {
    const double perGradient = gradients ? gradients->scale() : 0.;
    mixture->rowsPerPlace = perGradient > 0. ? rows / perGradient : 0.;
    mixture->firstRow = -axis.min * rows;
    illumination->hiddenLength = std::max(-1., mixture->table->hidden * perGradient);
    return;
  }
  const IntegralTable& ofPart = *mixture->parts[0]->table.integrals;
  mixture->rowsPerPlace = rows / ofPart.placesPerValue();
  mixture->firstRow = (ofPart.reference() - axis.min) * rows;
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

std::array<double, 4> colorOfExtreme(const VolumeKernelScene& scene, double place) noexcept
{
  const double value = scene.placeOrigin + (scene.perValue != 0. ? place / scene.perValue : 0.);
  const TransferFunction::Entry entry = scene.transferFunction.at(static_cast<float>(value));
  const double opacity = -std::expm1(-static_cast<double>(entry.extinction) * scene.settings.unitDistance);
  return { opacity * entry.r, opacity * entry.g, opacity * entry.b, opacity };
}

std::array<double, 4> colorOfSum(
  const VolumeKernelScene& scene, double sum, double length, bool crosses) noexcept
{
  const bool isAverage = scene.settings.blend == VolumeBlend::Average;
  if (isAverage ? !(length > 0.) : !crosses)
  {
    return {};
  }
  const double diagonal = diagonalOf(scene.field.octree().grid().bounds());
  const double grey =
    std::clamp(isAverage ? sum / length : sum * diagonal / scene.settings.unitDistance, 0., 1.);
  return { grey, grey, grey, 1. };
}

void showBlend(const VolumeKernelScene& scene, float* rgba) noexcept
{
  std::array<double, 4> color{};
  if (scene.features.loop == VolumeLoop::Sum)
  {
    color = colorOfSum(scene, rgba[0], rgba[1], rgba[2] != 0.f);
  }
  else if (rgba[1] != 0.f)
  {
    color = colorOfExtreme(scene, rgba[0]);
  }
  std::copy(color.begin(), color.end(), rgba);
}

} // namespace treeamr
