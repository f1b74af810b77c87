#include "Support/VolumeReference.h"

#include "Geometry/RayBox.h"
#include "Geometry/Trilinear.h"
#include "Interpolation/BlockGradients.h"
#include "Interpolation/VertexValues.h"
#include "Octree/TreePath.h"
#include "Support/LineIntegral.h"
#include "Support/VolumeLight.h"

#include <oneapi/tbb/blocked_range2d.h>
#include <oneapi/tbb/combinable.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace treeamr::test
{

namespace
{

constexpr int tileWidth = 8;
using RayMask = std::uint64_t;
static_assert(tileWidth * tileWidth == 64, "one bit per ray");

struct TileRay
{
  SlabRay slab;
  RayParts parts;
  double transmittance;
  std::array<double, 4> color; // and opacity: one minus the transmittance has no digits for faint things
  std::span<const TranslucentHit> hits; // to come
  // Of blends of values:
  Ray ray{};
  double extreme = std::numeric_limits<double>::quiet_NaN(); // value
  double sum = 0.;    // of opacity times value in the field's range times length
  double length = 0.; // that counts
};

/// The field inside a leaf from its 27 vertex values.
class LeafField
{
public:
  LeafField(const VertexValues& values, Range range) noexcept
    : values_(values)
    , range_(range)
  {
  }
  /// p: half widths from the leaf's lower corner, 0 to 2.
  double operator()(const std::array<double, 3>& p) const noexcept
  {
    int base = 0;
    std::array<double, 3> f;
    for (int a = 0; a < 3; ++a)
    {
      const bool upper = p[a] >= 1.;
      base += upper ? leafVertexStride[a] : 0;
      f[a] = std::clamp(p[a] - upper, 0., 1.);
    }
    // Rounding must not leave the range by which nodes are skipped.
    return std::clamp<double>(
      trilinear(cornersOf(values_.data() + base, leafVertexStride), f), range_.min, range_.max);
  }

private:
  const VertexValues& values_;
  Range range_;
};

/// The gradient inside a leaf from those at its 27 vertices.
class LeafGradient
{
public:
  /// path: to a leaf; zero where it has no parent.
  LeafGradient(TreePath& path, GradientEvaluator& evaluator)
  {
    if (path.depth() == 0)
    {
      return;
    }
    const int octant = octantAbove(path.index(), 0);
    path.ascend();
    BlockVertices vertices{};
    for (int v = 0; v < 27; ++v)
    {
      add(vertices, v % 3 + 2 * sideOf(octant, 0), v / 3 % 3 + 2 * sideOf(octant, 1),
        v / 9 + 2 * sideOf(octant, 2));
    }
    BlockGradients gradients{};
    evaluator.compute(BlockPath(path), BlockCells::Leaves, vertices, gradients);
    for (int v = 0; v < 27; ++v)
    {
      const Vec3& from = gradients[block::vertexIndex(
        v % 3 + 2 * sideOf(octant, 0), v / 3 % 3 + 2 * sideOf(octant, 1), v / 9 + 2 * sideOf(octant, 2))];
      for (int a = 0; a < 3; ++a)
      {
        components_[a][v] = from[a];
      }
    }
    path.descend(octant);
  }
  /// At all vertices.
  void useCentre() noexcept
  {
    for (auto& component : components_)
    {
      component.fill(component[13]);
    }
  }
  /// p: as LeafField has it.
  Vec3 operator()(const std::array<double, 3>& p) const noexcept
  {
    int base = 0;
    std::array<double, 3> f;
    for (int a = 0; a < 3; ++a)
    {
      const bool upper = p[a] >= 1.;
      base += upper ? leafVertexStride[a] : 0;
      f[a] = std::clamp(p[a] - upper, 0., 1.);
    }
    Vec3 gradient;
    for (int a = 0; a < 3; ++a)
    {
      gradient[a] = trilinear(cornersOf(components_[a].data() + base, leafVertexStride), f);
    }
    return gradient;
  }

private:
  std::array<std::array<double, 27>, 3> components_{};
};

class TileRenderer
{
public:
  TileRenderer(const Field& field, const TransferFunction& transferFunction, const Camera& camera,
    const RayStops& stops, const VolumeSettings& settings, bool converged, const ReferenceColors* colors,
    const ReferenceTable* table)
    : colors_(colors)
    , table_(table)
    , other_(colors ? &colors->field
          : table   ? table->second
                    : nullptr)
    , field_(field)
    , transferFunction_(transferFunction)
    , camera_(camera)
    , stops_(stops)
    , settings_(settings)
    , line_(converged ? std::make_optional<LineIntegral>(transferFunction) : std::nullopt)
    , ranges_(settings.skipEmpty ? &field.nodeRanges() : nullptr)
    , path_(field.octree())
    , isLit_(!blendsValues(settings.blend) && !transferFunction.hasCategories() &&
        (settings.shading || settings.gradientOpacity || (table && !table->second)))
    , evaluator_(colors ? colors->field : field)
  {
  }

  void render(int x0, int y0, Image& image)
  {
    rays_.clear();
    RayMask active = 0;
    const int x1 = std::min(x0 + tileWidth, image.width);
    const int y1 = std::min(y0 + tileWidth, image.height);
    for (int y = y0; y < y1; ++y)
    {
      for (int x = x0; x < x1; ++x)
      {
        const Ray ray = camera_.ray(x, y);
        TileRay tileRay{ SlabRay(ray), stops_.parts(camera_, ray, x, y), 1., {}, {} };
        tileRay.slab.enterUpperFaces(field_.octree().grid().bounds());
        tileRay.ray = ray;
        if (settings_.blend == VolumeBlend::Slice)
        {
          leaveSlice(tileRay);
        }
        if (stops_.hits)
        {
          const std::size_t pixel = static_cast<std::size_t>(y) * image.width + x;
          const std::size_t first = stops_.hits->first[pixel];
          tileRay.hits = stops_.hits->hits.subspan(first, stops_.hits->first[pixel + 1] - first);
          trimHits(tileRay, ray, pixel);
        }
        if (tileRay.parts.count > 0)
        {
          active |= RayMask(1) << rays_.size();
        }
        rays_.push_back(tileRay);
      }
    }
    direction_ = rays_.front().slab.direction;
    path_.reset();
    if (active != 0 && !path_.node().isNone())
    {
      visit(active, field_.range());
    }
    for (TileRay& ray : rays_)
    {
      crossHits(ray, std::numeric_limits<double>::infinity());
      blend(ray);
    }
    for (int y = y0, r = 0; y < y1; ++y)
    {
      for (int x = x0; x < x1; ++x, ++r)
      {
        float* rgba = image.rgba.data() + 4 * (static_cast<std::size_t>(y) * image.width + x);
        std::transform(
          rays_[r].color.begin(), rays_[r].color.end(), rgba, [](double c) { return static_cast<float>(c); });
      }
    }
  }

  const VolumeStatistics& statistics() const noexcept { return statistics_; }

private:
  /// Of a ray's parts what begins in the plane, to the next number.
  void leaveSlice(TileRay& ray) const noexcept
  {
    const auto& [normal, offset] = settings_.slice;
    const double at = (offset - dot(normal, ray.ray.origin)) / dot(normal, ray.ray.direction);
    RayParts met;
    for (int i = 0; i < ray.parts.count; ++i)
    {
      if (ray.parts.begin[i] <= at && at < ray.parts.end[i])
      {
        met.add(at, std::nextafter(at, std::numeric_limits<double>::infinity()));
      }
    }
    ray.parts = met;
  }

  /// To those between the ray's depths.
  void trimHits(TileRay& tileRay, const Ray& ray, std::size_t pixel) const noexcept
  {
    const double begin = stops_.beginDepth ? stops_.beginDepth[pixel] : 0.;
    const double end = stops_.endDepth ? stops_.endDepth[pixel] : 1.;
    std::span<const TranslucentHit>& hits = tileRay.hits;
    if (!(begin < end))
    {
      hits = {};
    }
    while (!hits.empty() && hits.front().t < camera_.tFromDepth(ray, begin))
    {
      hits = hits.subspan(1);
    }
    while (!hits.empty() && !(hits.back().t < camera_.tFromDepth(ray, end)))
    {
      hits = hits.first(hits.size() - 1);
    }
  }

  double opacityOf(double value) const noexcept
  {
    return -std::expm1(-static_cast<double>(transferFunction_.at(static_cast<float>(value)).extinction) *
      settings_.unitDistance);
  }
  double inRange(double value) const noexcept
  {
    const Range range = field_.range();
    return (value - range.min) / (static_cast<double>(range.max) - range.min);
  }

  /// The colour of what a ray has of values.
  void blend(TileRay& ray) const noexcept
  {
    switch (settings_.blend)
    {
      case VolumeBlend::Maximum:
      case VolumeBlend::Minimum:
        if (!std::isnan(ray.extreme))
        {
          const TransferFunction::Entry e = transferFunction_.at(static_cast<float>(ray.extreme));
          const double opacity = opacityOf(ray.extreme);
          ray.color = { opacity * e.r, opacity * e.g, opacity * e.b, opacity };
        }
        break;
      case VolumeBlend::Average:
        if (ray.length > 0.)
        {
          const double grey = std::clamp(ray.sum / ray.length, 0., 1.);
          ray.color = { grey, grey, grey, 1. };
        }
        break;
      case VolumeBlend::Additive:
      {
        const Bounds domain = field_.octree().grid().bounds();
        bool meets = false;
        for (int i = 0; i < ray.parts.count; ++i)
        {
          double t0 = ray.parts.begin[i];
          double t1 = ray.parts.end[i];
          meets = meets || (ray.slab.clip(domain.min, domain.max, t0, t1) && t0 < t1);
        }
        if (meets)
        {
          const double grey = std::clamp(ray.sum / settings_.unitDistance, 0., 1.);
          ray.color = { grey, grey, grey, 1. };
        }
        break;
      }
      default:
        break;
    }
  }

  void addExtreme(TileRay& ray, double value) const noexcept
  {
    if (std::isnan(ray.extreme) ||
      (settings_.blend == VolumeBlend::Maximum ? value > ray.extreme : value < ray.extreme))
    {
      ray.extreme = value;
    }
  }

  /// Of a leaf's way of `length`, `samples` times.
  template <class FieldAt>
  void addValues(TileRay& ray, const FieldAt& fieldAt, const std::array<double, 5>& ends, double length,
    int samples) const noexcept
  {
    if (settings_.blend == VolumeBlend::Maximum || settings_.blend == VolumeBlend::Minimum)
    {
      // Smooth between the ends, where the least and the largest values may be.
      constexpr int parts = 256;
      for (std::size_t i = 0; i + 1 < ends.size(); ++i)
      {
        for (int p = 0; p <= parts && ends[i] < ends[i + 1]; ++p)
        {
          addExtreme(ray, fieldAt(std::lerp(ends[i], ends[i + 1], static_cast<double>(p) / parts)));
        }
      }
      return;
    }
    for (int i = 0; i < samples; ++i)
    {
      const double value = fieldAt((i + 0.5) / samples);
      const Range& counted = settings_.averageRange;
      if (settings_.blend == VolumeBlend::Additive || (value >= counted.min && value <= counted.max))
      {
        ray.sum += opacityOf(value) * inRange(value) * length / samples;
        ray.length += length / samples;
      }
    }
  }

  /// Takes a ray across its hits before `end`.
  void crossHits(TileRay& ray, double end) const noexcept
  {
    for (; !ray.hits.empty() && ray.hits.front().t < end; ray.hits = ray.hits.subspan(1))
    {
      const TranslucentHit& hit = ray.hits.front();
      if (!(ray.transmittance > settings_.leastTransmittance))
      {
        continue;
      }
      const double weight = ray.transmittance * hit.rgba[3];
      for (int c = 0; c < 3; ++c)
      {
        ray.color[c] += weight * hit.rgba[c];
      }
      ray.color[3] += weight;
      ray.transmittance -= weight;
    }
  }

  /// Whether a ray's [t0, t1) has something to draw.
  static bool meetsParts(const TileRay& ray, double t0, double t1) noexcept
  {
    bool meets = false;
    for (int i = 0; i < ray.parts.count; ++i)
    {
      meets = meets || std::max(t0, ray.parts.begin[i]) < std::min(t1, ray.parts.end[i]);
    }
    return meets;
  }

  /// parent: the parent's range, of use when empty nodes are skipped.
  void visit(RayMask active, Range parent) noexcept
  {
    const NodeRef node = path_.node();
    Range range = parent;
    if (node.isInner() && ranges_)
    {
      range = ranges_->of(node.index(), parent);
      if (settings_.blend == VolumeBlend::Composite && !transferFunction_.isVisible(range))
      {
        return;
      }
    }
    const Bounds box = field_.octree().grid().nodeBounds(path_.index(), path_.depth());
    RayMask crossing = 0;
    for (RayMask rest = active; rest != 0; rest &= rest - 1)
    {
      const int r = std::countr_zero(rest);
      const TileRay& ray = rays_[r];
      double t0 = ray.parts.begin[0];
      double t1 = ray.parts.end[ray.parts.count - 1];
      if (ray.transmittance > settings_.leastTransmittance && ray.slab.clip(box.min, box.max, t0, t1) &&
        meetsParts(ray, t0, t1))
      {
        crossing |= RayMask(1) << r;
        leafInterval_[r] = { t0, t1 };
      }
    }
    if (crossing == 0)
    {
      return;
    }
    if (node.isLeaf())
    {
      integrateLeaf(box, crossing);
      return;
    }
    ++statistics_.nodes;
    Vec3 middle;
    for (int a = 0; a < 3; ++a)
    {
      middle[a] = field_.octree().grid().nodePlane(a, 2 * path_.index()[a] + 1, path_.depth() + 1);
    }
    const int nearest = camera_.nearestOctant(middle, direction_);
    for (int i = 0; i < 8; ++i)
    {
      const int octant = i ^ nearest;
      if (!field_.octree().child(node, octant).isNone())
      {
        path_.descend(octant);
        visit(crossing, range);
        path_.ascend();
      }
    }
  }

  void integrateLeaf(const Bounds& box, RayMask crossing) noexcept
  {
    if (field_.octree().isGhost(path_.node().index()))
    {
      return;
    }
    VertexValues values;
    if (transferFunction_.hasCategories() || settings_.nearest)
    {
      values.fill(field_.relative(path_.node()));
    }
    else
    {
      values = vertexValues<VertexRule::GTI>(path_, field_, memo_);
      ++statistics_.cells;
    }
    const Range range = hull(values);
    if (settings_.skipEmpty && settings_.blend == VolumeBlend::Composite &&
      !transferFunction_.isVisible(range))
    {
      return;
    }
    const LeafField leafField(values, range);
    VertexValues colorValues;
    if (other_)
    {
      colorValues = vertexValues<VertexRule::GTI>(path_, *other_, colorMemo_);
      if (settings_.nearest)
      {
        colorValues.fill(static_cast<float>(other_->relative(path_.node())));
      }
      color_.emplace(colorValues, hull(colorValues));
    }
    if (isLit_)
    {
      gradient_.emplace(path_, evaluator_);
      if (settings_.nearest)
      {
        gradient_->useCentre();
      }
    }
    std::array<double, 3> halfWidths; // per data coordinate
    for (int a = 0; a < 3; ++a)
    {
      halfWidths[a] = 2. / (box.max[a] - box.min[a]);
    }
    for (; crossing != 0; crossing &= crossing - 1)
    {
      const int r = std::countr_zero(crossing);
      integrateParts(rays_[r], leafInterval_[r], box, halfWidths, leafField);
    }
  }

  /// From stop to stop.
  void integrateParts(TileRay& ray, const std::array<double, 2>& interval, const Bounds& box,
    const std::array<double, 3>& halfWidths, const LeafField& leafField) noexcept
  {
    for (int i = 0; i < ray.parts.count; ++i)
    {
      double begin = std::max(interval[0], ray.parts.begin[i]);
      const double end = std::min(interval[1], ray.parts.end[i]);
      while (begin < end)
      {
        crossHits(ray, std::nextafter(begin, end)); // that are passed
        const double stop = ray.hits.empty() ? end : std::min(end, ray.hits.front().t);
        if (ray.transmittance > settings_.leastTransmittance)
        {
          integrate(ray, { begin, stop }, box, halfWidths, leafField);
        }
        begin = stop;
      }
    }
  }

  /// Midpoint samples: emission and absorption with the sample's extinction over its step.
  void integrate(TileRay& ray, const std::array<double, 2>& interval, const Bounds& box,
    const std::array<double, 3>& halfWidths, const LeafField& leafField) noexcept
  {
    const double length = interval[1] - interval[0];
    std::array<double, 3> position;
    std::array<double, 3> perLength;
    double squared = 0.;
    for (int a = 0; a < 3; ++a)
    {
      const double d = ray.slab.direction[a] * halfWidths[a];
      position[a] = (ray.slab.origin[a] + interval[0] * ray.slab.direction[a] - box.min[a]) * halfWidths[a];
      perLength[a] = d * length;
      squared += d * d;
    }
    const double widths = 0.5 * std::sqrt(squared) * length;
    const int samples = std::max(1, static_cast<int>(std::ceil(widths * settings_.samplesPerCell)));
    const bool isSlice = settings_.blend == VolumeBlend::Slice;
    const double step = isSlice ? settings_.unitDistance : length / samples;
    const auto fieldAt = [&](double f) {
      return leafField(
        { position[0] + f * perLength[0], position[1] + f * perLength[1], position[2] + f * perLength[2] });
    };
    std::array<double, 5> ends{ 0., 1., 1., 1., 1. };
    for (int a = 0; a < 3; ++a)
    {
      ends[a + 1] = std::clamp((1. - position[a]) / perLength[a], 0., 1.); // the middle of the leaf
      ends[a + 1] = std::isnan(ends[a + 1]) ? 1. : ends[a + 1];
    }
    std::sort(ends.begin(), ends.end());
    if (blendsValues(settings_.blend))
    {
      addValues(ray, fieldAt, ends, length, samples);
      statistics_.samples += samples;
      return;
    }
    if (line_)
    {
      for (std::size_t i = 0; i + 1 < ends.size(); ++i)
      {
        if (ends[i] < ends[i + 1])
        {
          addConverged(ray, fieldAt, ends[i], fieldAt(ends[i]), ends[i + 1], fieldAt(ends[i + 1]), length, 0);
        }
      }
      return;
    }
    for (int i = 0; i < samples; ++i)
    {
      const double f = (i + 0.5) / samples;
      addPoint(ray, leafField,
        { position[0] + f * perLength[0], position[1] + f * perLength[1], position[2] + f * perLength[2] },
        interval[0] + f * length, step);
    }
    statistics_.samples += samples;
  }

  /// t: of the point, which stands for a step's length.
  void addPoint(TileRay& ray, const LeafField& leafField, const Vec3& inLeaf, double t, double step) noexcept
  {
    const auto value = static_cast<float>(leafField(inLeaf));
    TransferFunction::Entry e = transferFunction_.at(value);
    if (e.extinction == 0.f)
    {
      return;
    }
    if (table_)
    {
      e = table_->function.at(
        value, color_ ? (*color_)(inLeaf) : std::sqrt(dot((*gradient_)(inLeaf), (*gradient_)(inLeaf))));
    }
    std::array<double, 3> color{ e.r, e.g, e.b };
    if (colors_)
    {
      const TransferFunction::Entry own = colors_->function.at(static_cast<float>((*color_)(inLeaf)));
      color = { own.r, own.g, own.b };
    }
    double extinction = e.extinction;
    if (isLit_)
    {
      const Vec3 gradient = (*gradient_)(inLeaf);
      if (settings_.gradientOpacity && !table_)
      {
        extinction *= gradientOpacity(*settings_.gradientOpacity, gradient);
      }
      if (settings_.shading)
      {
        color = lightVolume(*settings_.shading, pointAt(ray.ray, t), gradient, color);
      }
    }
    const double weight = ray.transmittance * -std::expm1(-extinction * step);
    for (int c = 0; c < 3; ++c)
    {
      ray.color[c] += weight * color[c];
    }
    ray.color[3] += weight;
    ray.transmittance -= weight;
  }

  /// From one part of the way, and the field there, to another. length: of the whole way.
  template <class FieldAt>
  void addConverged(TileRay& ray, const FieldAt& fieldAt, double begin, double first, double end, double last,
    double length, int depth)
  {
    constexpr int deepest = 24;
    constexpr int parts = 4;
    std::array<double, parts + 1> values{ first, 0., 0., 0., last };
    double bend = 0.;
    for (int i = 1; i < parts; ++i)
    {
      const double part = static_cast<double>(i) / parts;
      values[i] = fieldAt(std::lerp(begin, end, part));
      bend = std::max(bend, std::abs(values[i] - std::lerp(first, last, part)));
    }
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    if (ray.transmittance < settings_.leastTransmittance ||
      !transferFunction_.isVisible({ static_cast<float>(*low - bend), static_cast<float>(*high + bend) }))
    {
      return;
    }
    const double size = std::max(std::abs(first), std::abs(last));
    const double depthThere = line_->opticalDepth(*low - bend, *high + bend, length * (end - begin));
    // Of the field's change: by as much the slope errs, and so what a peak of the function shows.
    const double straight = std::clamp(2e-4 / (ray.transmittance * depthThere), 1e-3, 0.1);
    if (bend > std::max(straight * std::abs(last - first), 1e-13 * size) && depth < deepest)
    {
      const double middle = 0.5 * (begin + end);
      addConverged(ray, fieldAt, begin, first, middle, values[2], length, depth + 1);
      addConverged(ray, fieldAt, middle, values[2], end, last, length, depth + 1);
      return;
    }
    for (int i = 0; i < parts; ++i)
    {
      line_->addLight(values[i], values[i + 1], length * (end - begin) / parts, ray.color, ray.transmittance);
    }
  }

  const ReferenceColors* colors_;
  const ReferenceTable* table_;
  const Field* other_; // of one of these
  VertexMemo colorMemo_;
  std::optional<LeafField> color_; // of the other field in the leaf
  const Field& field_;
  const TransferFunction& transferFunction_;
  const Camera& camera_;
  const RayStops& stops_;
  const VolumeSettings& settings_;
  std::optional<LineIntegral> line_; // of converged pictures
  const NodeRanges* ranges_;         // null: nothing is skipped
  TreePath path_;
  VertexMemo memo_;
  std::vector<TileRay> rays_;
  std::array<std::array<double, 2>, 64> leafInterval_; // t of entry and exit by ray
  Vec3 direction_;
  VolumeStatistics statistics_;
  bool isLit_;
  GradientEvaluator evaluator_;
  std::optional<LeafGradient> gradient_; // of the leaf, while it is lit
};

VolumeStatistics render(const Field& field, const TransferFunction& transferFunction, const Camera& camera,
  const RayStops& stops, const VolumeSettings& settings, bool converged, const ReferenceColors* colors,
  const ReferenceTable* table, Image& image)
{
  tbb::combinable<VolumeStatistics> statistics;
  const int rows = (image.height + tileWidth - 1) / tileWidth;
  const int columns = (image.width + tileWidth - 1) / tileWidth;
  tbb::parallel_for(tbb::blocked_range2d<int>(0, rows, 1, 0, columns, 8), [&](const auto& tiles) {
    TileRenderer renderer(field, transferFunction, camera, stops, settings, converged, colors, table);
    for (int row = tiles.rows().begin(); row < tiles.rows().end(); ++row)
    {
      for (int column = tiles.cols().begin(); column < tiles.cols().end(); ++column)
      {
        renderer.render(column * tileWidth, row * tileWidth, image);
      }
    }
    statistics.local() += renderer.statistics();
  });
  return statistics.combine([](VolumeStatistics a, const VolumeStatistics& b) { return a += b; });
}

} // namespace

VolumeStatistics renderVolumeReference(const Field& field, const TransferFunction& transferFunction,
  const Camera& camera, const RayStops& stops, const VolumeSettings& settings, Image& image,
  const ReferenceColors* colors, const ReferenceTable* table)
{
  return render(field, transferFunction, camera, stops, settings, false, colors, table, image);
}

void renderVolumeConverged(const Field& field, const TransferFunction& transferFunction, const Camera& camera,
  const RayStops& stops, Image& image)
{
  render(field, transferFunction, camera, stops, { .leastTransmittance = 0x1p-20f }, true, nullptr, nullptr,
    image);
}

} // namespace treeamr::test
