// What the vectorised volume renderer is given, and its entry: one source for every instruction set.
#pragma once

#include "Field/TransferFunction2D.h"
#include "Interpolation/BlockCache.h"
#include "Interpolation/GradientCache.h"
#include "Volume/Kernel/VolumeTable.h"
#include "Volume/ShadowLattice.h"
#include "Volume/Volume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace treeamr
{

class TileRelay;

/// What the kernel makes of a ray's samples; each compiled apart.
enum class VolumeLoop
{
  Plain,   // composite, of the transfer function alone
  Lit,     // composite, with light, gradient opacity or colours by another field; slices
  Extreme, // maximum or minimum
  Sum,     // average or additive
  Colors   // none of its own: of blocks whose field colours a lit loop, by rows of its table's integrals
};

/// That settings ask for, of a field of categories or not.
VolumeLoop volumeLoop(const VolumeSettings& settings, bool hasCategories) noexcept;
/// Whether frames of these settings need the field's gradients.
bool usesGradients(const VolumeSettings& settings, bool hasCategories) noexcept;

/// What a frame needs beyond the common case, chosen once: what is absent costs nothing.
struct SceneFeatures
{
  VolumeLoop loop = VolumeLoop::Plain;
  bool commonOrigin = true;    // all rays start at one point; compiled apart
  bool doubles = false;        // floats do not resolve the view, the domain or the values; compiled apart
  bool preIntegration = false; // some cell may vary more than samples of the table can follow
  bool constants = false;      // each leaf is one: of categories, and where nothing is reconstructed
  bool means = false;          // nodes may be drawn from their means
  bool slices = false;         // rays are where they meet a plane alone; of lit loops
  bool slicesFaces = false;    // it is one in which cells may meet: what it shows is of either side
};

struct VolumeKernelScene;

/// What other fields are to a sample.
enum class VolumeMixing
{
  Colors,      // one colours it
  Channels,    // three are its red, green and blue, as each one's function has them
  Independent, // up to four, each with colours and extinctions, among them the volume's own
  Table        // none, or one that makes with the volume's own an entry of a table
};

/// A TransferFunction2D with extinctions as VolumeTable has them.
struct KernelTable2D
{
  /// diagonal: of the domain. byGradient: the second value is the length of the field's gradient.
  KernelTable2D(const TransferFunction2D& made, double diagonal, bool byGradient);

  TransferFunction2D function;
  bool byGradient;
  double hidden; // of the second axis what lies below it shows nothing; infinite: nothing does
};

struct KernelMixture
{
  VolumeMixing mixing;
  /// Of the same view and octree, their tables with integrals.
  std::vector<std::shared_ptr<const VolumeKernelScene>> parts;
  std::array<float, 4> weights; // of what is independent
  const KernelTable2D* table = nullptr;
  ///@{
  /// Of the table, per place in VolumeTable and per place of the part's or length of a gradient in GradientCache.
  double columnsPerPlace = 0.;
  double rowsPerPlace = 0.;
  double firstRow = 0.;
  ///@}
};

/// A power of cosines.
struct Falloff
{
  explicit Falloff(double power) noexcept
    : exponent(power)
  {
    constexpr double mostMultiplied = 1024.;
    if (power <= mostMultiplied && power == std::floor(power))
    {
      whole = static_cast<int>(power);
      least = power > 0. ? std::exp2(-60. / power) : 0.;
    }
  }

  double exponent;
  int whole = -1;    // the same, to multiply by; negative: none
  double least = 0.; // what is less has a power that floats need not tell from 0, and could hardly
};

/// Of VolumeShading, with its coefficients in the colours.
struct KernelLight
{
  bool
    isAtEye; // shines along the lines of sight, as strong everywhere; then the rest but the colours is of no use
  bool isPositional;
  bool isCone;
  Vec3 position;
  Vec3 direction;
  double coneCosine;
  Falloff inCone{ 0. };
  Vec3 attenuation;
  Vec3 diffuse;
  Vec3 specular;
  const float* transmittance = nullptr; // at a ShadowLattice's nodes; null: nothing dims it
};

/// VolumeScattering in the kernel's terms.
struct KernelScattering
{
  double blending;           // 0 to 1
  double depthPerExtinction; // of entries, over the length that opacities count for it
  double anisotropy;
  ///@{
  /// A ShadowLattice's nodes, of which the first one is at 0, and the kernel's origin in its cells.
  std::array<int, 3> nodes;
  Vec3 cellsPerUnit;
  Vec3 reference;
  ///@}
};

/// VolumeShading and GradientOpacity in the kernel's terms. Points and lights are in the lights' coordinates, in units
/// of about the domain's diagonal there.
struct VolumeIllumination
{
  VolumeIllumination(const VolumeSettings& settings, const VolumeKernelScene& scene);

  bool usesGradients;
  bool shades;
  bool twoSided = true;
  bool shines = false;      // has highlights
  bool needsPoints = false; // for more than the way that rays go
  bool seesAlongRays = false;
  double ambient = 0.;
  double unit = 1.; // of the lights' coordinates, in the kernel
  Vec3 ambientLight{};
  Falloff ofHighlights{ 1. };
  std::vector<KernelLight> lights;
  std::optional<KernelScattering> scattering;
  std::array<Vec3, 3> normalFromGradient{};              // rows; up to a positive factor
  std::array<std::array<double, 4>, 3> viewFromKernel{}; // rows
  const float* gradientOpacity;                          // null: none
  double entriesPerLength = 0.;                          // of a gradient as GradientCache scales them
  double lastEntry = 0.;
  ///@{
  /// Gradients from here on have one opacity, which is all that counts of them; infinite: they have not.
  double longLength = std::numeric_limits<double>::infinity();
  double ofLong = 1.;
  ///@}
  double hiddenLength = -1.; // of gradients up to which gradient opacity is 0; negative: none

  /// The lights in data coordinates; none where their own have fewer dimensions.
  std::vector<ShadowLattice::Source> sources(const Matrix4& lightsFromData) const;
  /// shadows: of the sources, of which there are as many as lights or none.
  void scatter(const VolumeScattering& wanted, const ShadowLattice& shadows, const VolumeKernelScene& scene);

private:
  void place(const VolumeShading& shading, const VolumeKernelScene& scene);
  void addLights(const VolumeShading& shading);
};

/// The kernel counts, in floats unless its features tell otherwise, from `reference`, in units that make the domain's
/// diagonal 1, both as a length on the central ray and in data coordinates, so that neither offsets nor units cost it
/// digits.
struct VolumeKernelScene
{
  /// Refers to all of these. The table's integrals are wanted when the features tell so. gradients: where they are used.
  VolumeKernelScene(const Field& field, const TransferFunction& transferFunction, const VolumeTable& table,
    const RayView& view, const VolumeSettings& settings, BlockCache& kept, GradientCache* gradients,
    Image* image);

  void mix(KernelMixture others);
  /// Whether what is seen is not the transfer function's alone.
  bool isOfMany() const noexcept { return mixture && mixture->mixing == VolumeMixing::Independent; }
  /// Whether it is a table's, and by gradients.
  bool readsTable() const noexcept { return mixture && mixture->table; }
  bool readsGradients() const noexcept { return readsTable() && mixture->table->byGradient; }

  const Field& field;
  const TransferFunction& transferFunction;
  const VolumeTable& table;
  const Camera& camera;
  const RayStops& stops;
  const VolumeSettings& settings;
  BlockCache& kept;
  GradientCache* gradients; // null: none are used
  const Field* ofGradients; // its vertex gradients are these
  Image* image;             // null: only groups of pixels are rendered
  bool goesOn = false;      // rays start with what the image has of them
  const TileRelay* relay = nullptr; // that says what of the domain is drawn; null: all that the stops leave
  const NodeRanges* ranges; // null: nothing is skipped

  SceneFeatures features;
  Vec3 reference;    // data coordinates; the eye when all rays start there
  Vec3 direction;    // of the ray in the image's middle, of all rays in parallel projection
  double tReference; // t that the kernel counts from
  double scale;      // kernel units per unit of world length
  double dataScale;  // and of data coordinates
  PixelFan fan;      // common origin only
  /// Width of a pixel at the kernel's t, in kernel units: at t = 0, and its growth.
  double pixelWidth;
  double pixelGrowth;
  std::optional<VolumeIllumination> illumination; // of lit loops
  std::optional<KernelMixture> mixture;           // of lit loops
  double unitDepth;                               // of the unit distance, per extinction of the table
  double partOfFinestStep =
    1.; // of values: less for slices, in which the table's least depth is the unit distance
  /// Of the loops that sample values themselves: their places are (value - placeOrigin) * perValue, 0 to 1 in the
  /// field's range, in that of a minimum from the largest value to the smallest.
  double placeOrigin;
  double perValue;

private:
  void place();
  void placeTable();
  void measurePixels();
  bool resolves() const;
};

///@{
/// What is shown of a ray with this extreme place, or with these sums of opacity times place and of lengths: colour times
/// opacity, and opacity. crosses: whether any of the ray is in the domain.
std::array<double, 4> colorOfExtreme(const VolumeKernelScene& scene, double place) noexcept;
std::array<double, 4> colorOfSum(
  const VolumeKernelScene& scene, double sum, double length, bool crosses) noexcept;
///@}
/// Makes these of what a blend of values that goes on leaves in an image's pixel: of extremes the place and whether there is
/// one, of sums both and whether the ray crosses the domain; the last number is 0.
void showBlend(const VolumeKernelScene& scene, float* rgba) noexcept;

/// What the transfer function does in a hull, per kernel unit.
struct HullTerms
{
  double variation; // of the optical depth
  double curvature; // sum of what bends in it
  double entries;   // the hull's width
};

/// Whether points follow the optical depth along one width of a leaf: what lies between two samples may be missed, at
/// most the whole variation, but a smooth function errs by its bend over the square of the samples; and what a sample
/// stands for must not hide itself. For any number of samples, so that more of them are never worse.
inline bool pointsSuffice(const VolumeKernelScene& scene, const HullTerms& hull, double leafWidth) noexcept
{
  constexpr double mostMissed = 0.8;
  constexpr double mostBent = 6.4;
  constexpr double mostAtOnce = 4.;
  const double length = scene.dataScale / scene.scale * leafWidth;
  const double variation = length * hull.variation;
  return variation <= mostMissed ||
    (variation <= mostAtOnce && length * hull.curvature * hull.entries <= mostBent);
}

constexpr int volumeTileWidth = 16;
static_assert(volumeTileWidth == 4 * PixelGroup::width);

/// A variant of the kernel, compiled for the best instruction set of this machine.
struct VolumeLoops
{
  /// Renders the tiles [columnBegin, columnEnd) of a row of tiles.
  VolumeStatistics (*renderTiles)(const VolumeKernelScene& scene, int row, int columnBegin, int columnEnd);
  /// See Volume::renderGroups().
  void (*renderGroups)(const VolumeKernelScene& scene, std::span<const PixelGroup> groups, float* rgba);
  /// See Volume::renderWithoutWalk(). position: in the table.
  VolumeStatistics (*repeatInCache)(
    const VolumeKernelScene& scene, int row, int columns, float position, int repeats);
};

VolumeLoops volumeLoopsFromOnePoint();
VolumeLoops volumeLoopsOfAnyRays();
VolumeLoops volumeLoopsInDoubles();
VolumeLoops litVolumeLoopsFromOnePoint();
VolumeLoops litVolumeLoops();
VolumeLoops litVolumeLoopsInDoubles();
VolumeLoops extremeVolumeLoops();
VolumeLoops extremeVolumeLoopsInDoubles();
VolumeLoops sumVolumeLoops();
VolumeLoops sumVolumeLoopsInDoubles();
/// That a scene needs.
VolumeLoops volumeLoops(const SceneFeatures& features);

} // namespace treeamr
