#include "Volume/ShadowLattice.h"

#include "Field/NodeRanges.h"
#include "Interpolation/PointSampler.h"
#include "Octree/Octree.h"
#include "Volume/Kernel/IntegralTable.h"

#include <oneapi/tbb/blocked_range2d.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace treeamr
{

namespace
{

/// Opacity as a gradient's length has it.
float opacityOf(const GradientOpacity& function, double length)
{
  const auto last = static_cast<double>(function.entries.size() - 1);
  const double place = std::min(length / function.longest, 1.) * last;
  const auto entry = static_cast<std::size_t>(std::min(std::floor(place), last - 1.));
  return static_cast<float>(
    std::lerp(function.entries[entry], function.entries[entry + 1], place - static_cast<double>(entry)));
}

/// Whether they are one light, which a moving camera sees in other places, rounded. size: of the domain.
bool areAlike(const ShadowLattice::Source& a, const ShadowLattice::Source& b, double size)
{
  constexpr double rounding = 1e-9;
  const Vec3 difference{ a.place[0] - b.place[0], a.place[1] - b.place[1], a.place[2] - b.place[2] };
  const double place = std::sqrt(dot(a.place, a.place)) + (a.isPositional ? size : 0.);
  return a.isPositional == b.isPositional && std::sqrt(dot(difference, difference)) <= rounding * place;
}

/// Calls mark(box) for parts of the domain that hold all that is visible, none of them much wider than `width`.
template <class Mark>
class VisibleParts
{
public:
  VisibleParts(const Field& field, const TransferFunction& transferFunction, double width, const Mark& mark)
    : octree_(field.octree())
    , ranges_(field.nodeRanges())
    , transferFunction_(transferFunction)
    , width_(width)
    , mark_(mark)
  {
  }

  void visit(NodeRef node, const std::array<Coord, 3>& index, Range range) const
  {
    if (node.isInner())
    {
      range = ranges_.of(node.index(), range);
      if (!transferFunction_.isVisible(range))
      {
        return;
      }
    }
    const Bounds box = octree_.grid().nodeBounds(index, node.depth());
    if (!node.isInner() || box.max[0] - box.min[0] <= width_)
    {
      mark_(box);
      return;
    }
    const Octree::Children children = octree_.children(node.index());
    for (int octant = 0; octant < 8; ++octant)
    {
      if ((children.inner() | children.leaf) >> octant & 1)
      {
        visit(children.node(octant, node.depth() + 1),
          { 2 * index[0] + (octant & 1), 2 * index[1] + (octant >> 1 & 1), 2 * index[2] + (octant >> 2) },
          range);
      }
    }
  }

private:
  const Octree& octree_;
  const NodeRanges& ranges_;
  const TransferFunction& transferFunction_;
  double width_;
  const Mark& mark_;
};

} // namespace

ShadowLattice::ShadowLattice(const Field& field, const TransferFunction& transferFunction,
  const IntegralTable& integrals, const std::optional<GradientOpacity>& gradientOpacity)
  : gradientOpacity_(gradientOpacity)
{
  const Bounds domain = field.octree().grid().bounds();
  double longest = 0.;
  for (int a = 0; a < 3; ++a)
  {
    longest = std::max(longest, domain.max[a] - domain.min[a]);
  }
  for (int a = 0; a < 3; ++a)
  {
    const double size = domain.max[a] - domain.min[a];
    const int cells = std::clamp(static_cast<int>(std::lround(cellsAcross * size / longest)), 1, cellsAcross);
    nodes_[a] = cells + 1;
    origin_[a] = domain.min[a];
    cell_[a] = size / cells;
  }
  const std::size_t count = index(0, 0, nodes_[2]);
  isVisible_.resize(count, 0);
  extinctions_.resize(count, 0.f);
  markVisible(field, transferFunction);
  measure(field, integrals);
}

template <class Use>
void ShadowLattice::forEachRow(const Use& use) const
{
  tbb::parallel_for(tbb::blocked_range2d<int>(0, nodes_[2], 1, 0, nodes_[1], 16), [&](const auto& rows) {
    for (int z = rows.rows().begin(); z < rows.rows().end(); ++z)
    {
      for (int y = rows.cols().begin(); y < rows.cols().end(); ++y)
      {
        use(y, z);
      }
    }
  });
}

void ShadowLattice::markVisible(const Field& field, const TransferFunction& transferFunction)
{
  const NodeRef root = field.octree().root();
  if (root.isNone())
  {
    return;
  }
  const auto mark = [this](const Bounds& box) {
    std::array<int, 3> first;
    std::array<int, 3> last;
    for (int a = 0; a < 3; ++a)
    {
      const auto node = [&](double place) {
        return std::clamp(static_cast<int>(place), 0, nodes_[a] - 1);
      };
      first[a] = node(std::floor((box.min[a] - origin_[a]) / cell_[a]));
      last[a] = node(std::ceil((box.max[a] - origin_[a]) / cell_[a]));
    }
    for (int z = first[2]; z <= last[2]; ++z)
    {
      for (int y = first[1]; y <= last[1]; ++y)
      {
        std::fill_n(&isVisible_[index(first[0], y, z)], last[0] - first[0] + 1, std::uint8_t(1));
      }
    }
  };
  VisibleParts(field, transferFunction, cell_[0], mark).visit(root, { 0, 0, 0 }, field.range());
}

/// Each is the mean over points around the node, or of it alone where no leaf is narrower than the lattice's cells, and for
/// each of these over the values that the field has as near to it.
void ShadowLattice::measure(const Field& field, const IntegralTable& integrals)
{
  const double unit = 1. / diagonalOf(field.octree().grid().bounds());
  tbb::enumerable_thread_specific<PointSampler> samplers([&field] { return PointSampler(field); });
  const RootGrid& grid = field.octree().grid();
  const Bounds domain = grid.bounds();
  bool isFine = false;
  for (int a = 0; a < 3; ++a)
  {
    const double root = (domain.max[a] - domain.min[a]) / grid.roots()[a];
    isFine = isFine || std::ldexp(root, -field.octree().leafLevels()) < cell_[a];
  }
  const int points = isFine ? 8 : 1;
  const double reach = isFine ? 0.25 : 0.5; // of a point, in cells
  const auto extinctionAround = [&](PointSampler& sampler, Vec3 point) {
    for (int a = 0; a < 3; ++a)
    {
      point[a] = std::clamp(point[a], domain.min[a], domain.max[a]);
    }
    FieldSample sample;
    if (!sampler.sample(point, sample))
    {
      return 0.;
    }
    double change = 0.; // up to the farthest of the values
    for (int a = 0; a < 3; ++a)
    {
      change += reach * cell_[a] * std::abs(sample.gradient[a]);
    }
    const Range range = field.range();
    const double low = std::clamp<double>(sample.value - change, range.min, range.max);
    const double high = std::clamp<double>(sample.value + change, range.min, range.max);
    double extinction = unit * integrals.meanExtinction(integrals.placeOf(low), integrals.placeOf(high));
    if (gradientOpacity_)
    {
      extinction *= opacityOf(*gradientOpacity_, std::sqrt(dot(sample.gradient, sample.gradient)));
    }
    return extinction;
  };
  forEachRow([&](int y, int z) {
    PointSampler& sampler = samplers.local();
    for (int x = 0; x < nodes_[0]; ++x)
    {
      const std::size_t node = index(x, y, z);
      double sum = 0.;
      for (int octant = 0; octant < points && isVisible_[node]; ++octant)
      {
        const auto at = [&](int axis, int i, int upper) {
          return origin_[axis] + cell_[axis] * (i + (isFine ? (upper ? 0.25 : -0.25) : 0.));
        };
        sum += extinctionAround(
          sampler, { at(0, x, octant & 1), at(1, y, octant >> 1 & 1), at(2, z, octant >> 2) });
      }
      extinctions_[node] =
        static_cast<float>(std::min(sum / points, static_cast<double>(TransferFunction::opaqueExtinction)));
    }
  });
}

void ShadowLattice::illuminate(const std::vector<Source>& sources, double reach, double worldPerData)
{
  const bool isLit = std::equal(sources.begin(), sources.end(), sources_.begin(), sources_.end(),
    [size = cell_[0] * nodes_[0] + cell_[1] * nodes_[1] + cell_[2] * nodes_[2]](
      const Source& a, const Source& b) { return areAlike(a, b, size); });
  if (isLit && reach == reach_ && std::abs(worldPerData - worldPerData_) <= 1e-9 * worldPerData)
  {
    return;
  }
  reach_ = reach;
  worldPerData_ = worldPerData;
  transmittances_.resize(sources.size());
  for (LargeVector<float>& transmittance : transmittances_)
  {
    transmittance.resize(extinctions_.size());
  }
  forEachRow([&](int y, int z) {
    const std::uint8_t* const areVisible = &isVisible_[index(0, y, z)];
    const bool isAny = std::find(areVisible, areVisible + nodes_[0], 1) != areVisible + nodes_[0];
    for (std::size_t light = 0; light < sources.size(); ++light)
    {
      float* const transmittance = &transmittances_[light][index(0, y, z)];
      if (isAny && !sources[light].isPositional)
      {
        shineAlong(y, z, sources[light], transmittance);
        continue;
      }
      for (int x = 0; x < nodes_[0]; ++x)
      {
        transmittance[x] = areVisible[x] ? comesThrough({ x, y, z }, sources[light]) : 1.f;
      }
    }
  });
  sources_ = sources;
}

float ShadowLattice::extinctionAt(const std::array<float, 3>& place) const noexcept
{
  std::array<int, 3> cell;
  std::array<float, 3> f;
  for (int a = 0; a < 3; ++a)
  {
    cell[a] = std::clamp(static_cast<int>(place[a]), 0, nodes_[a] - 2);
    f[a] = std::clamp(place[a] - static_cast<float>(cell[a]), 0.f, 1.f);
  }
  const float* const corner = &extinctions_[index(cell[0], cell[1], cell[2])];
  const std::ptrdiff_t row = nodes_[0];
  const std::ptrdiff_t slice = row * nodes_[1];
  const auto along = [](float part, float a, float b) { return a + part * (b - a); };
  const auto inRow = [&](const float* first) { return along(f[0], first[0], first[1]); };
  const auto inSlice = [&](const float* first) { return along(f[1], inRow(first), inRow(first + row)); };
  return along(f[2], inSlice(corner), inSlice(corner + slice));
}

ShadowLattice::Way ShadowLattice::wayFrom(const std::array<int, 3>& node, const Source& source) const noexcept
{
  Vec3 direction;
  for (int a = 0; a < 3; ++a)
  {
    direction[a] =
      source.isPositional ? source.place[a] - (origin_[a] + node[a] * cell_[a]) : -source.place[a];
  }
  Way way;
  const double length = std::sqrt(dot(direction, direction));
  if (!(length > 0.) || !std::isfinite(length))
  {
    return way;
  }
  double end = source.isPositional ? length : std::numeric_limits<double>::infinity();
  double inCube = 0.; // squared, per length
  for (int a = 0; a < 3; ++a)
  {
    direction[a] /= length;
    way.step += direction[a] * direction[a] * cell_[a]; // the mean width of cells along the way
    const double inCells = direction[a] / cell_[a];
    inCube += std::pow(inCells / (nodes_[a] - 1), 2);
    const double toFace = inCells > 0. ? nodes_[a] - 1 - node[a] : -node[a];
    end = inCells != 0. ? std::min(end, toFace / inCells) : end;
  }
  end = std::min(end, way.step + reach_ / std::sqrt(inCube));
  way.steps = std::max(end / way.step - 1., 0.);
  for (int a = 0; a < 3; ++a)
  {
    way.perStep[a] = static_cast<float>(way.step * direction[a] / cell_[a]);
  }
  return way;
}

/// Extinction there times the part of the step.
float ShadowLattice::partOfLastStep(const std::array<int, 3>& node, const Way& way) const noexcept
{
  const double whole = std::floor(way.steps);
  const double rest = way.steps - whole;
  std::array<float, 3> place;
  for (int a = 0; a < 3; ++a)
  {
    place[a] =
      static_cast<float>(node[a]) + static_cast<float>(1. + whole + 0.5 * rest) * way.perStep[a];
  }
  return static_cast<float>(rest) * extinctionAt(place);
}

float ShadowLattice::comesThrough(const std::array<int, 3>& node, const Source& source) const noexcept
{
  const Way way = wayFrom(node, source);
  std::array<float, 3> place;
  for (int a = 0; a < 3; ++a)
  {
    place[a] = static_cast<float>(node[a]) + 1.5f * way.perStep[a];
  }
  const auto worldStep = static_cast<float>(way.step * worldPerData_);
  constexpr float none = 20.f; // no light of single precision comes through
  float depth = 0.f;
  const auto whole = static_cast<int>(way.steps);
  for (int i = 0; i < whole && depth < none; ++i)
  {
    depth += worldStep * extinctionAt(place);
    for (int a = 0; a < 3; ++a)
    {
      place[a] += way.perStep[a];
    }
  }
  return std::exp(-depth - worldStep * partOfLastStep(node, way));
}

/// Of a row of nodes, whose ways to what is far away run beside each other: through the same places of their cells.
void ShadowLattice::shineAlong(int y, int z, const Source& source, float* transmittance) const
{
  const int count = nodes_[0];
  constexpr int most = cellsAcross + 1;
  std::array<Way, most> ways;
  std::array<int, most> whole{};
  std::array<float, most> depth{};
  std::array<float, most + 1> row{}; // of extinctions beside the nodes' places
  int mostWhole = 0;
  for (int x = 0; x < count; ++x)
  {
    ways[x] = wayFrom({ x, y, z }, source);
    whole[x] = static_cast<int>(ways[x].steps);
    mostWhole = std::max(mostWhole, whole[x]);
  }
  const std::array<float, 3>& perStep = ways[0].perStep; // of all
  for (int i = 0; i < mostWhole; ++i)
  {
    const float moved = static_cast<float>(i) + 1.5f;
    const std::array<float, 2> at{ static_cast<float>(y) + moved * perStep[1],
      static_cast<float>(z) + moved * perStep[2] };
    const int lowY = std::clamp(static_cast<int>(at[0]), 0, nodes_[1] - 2);
    const int lowZ = std::clamp(static_cast<int>(at[1]), 0, nodes_[2] - 2);
    const float fy = std::clamp(at[0] - static_cast<float>(lowY), 0.f, 1.f);
    const float fz = std::clamp(at[1] - static_cast<float>(lowZ), 0.f, 1.f);
    const float* const rows[4] = { &extinctions_[index(0, lowY, lowZ)], &extinctions_[index(0, lowY + 1, lowZ)],
      &extinctions_[index(0, lowY, lowZ + 1)], &extinctions_[index(0, lowY + 1, lowZ + 1)] };
    const float weights[4] = { (1.f - fy) * (1.f - fz), fy * (1.f - fz), (1.f - fy) * fz, fy * fz };
    for (int x = 0; x < count; ++x)
    {
      row[x] = weights[0] * rows[0][x] + weights[1] * rows[1][x] + weights[2] * rows[2][x] +
        weights[3] * rows[3][x];
    }
    row[count] = row[count - 1];
    const float shift = std::floor(moved * perStep[0]);
    const float f = moved * perStep[0] - shift;
    const int cells = static_cast<int>(shift);
    const int first = std::clamp(-cells, 0, count);
    const int end = std::clamp(count - cells, first, count);
    for (int x = first; x < end; ++x)
    {
      const float extinction = row[x + cells] + f * (row[x + cells + 1] - row[x + cells]);
      depth[x] += i < whole[x] ? extinction : 0.f;
    }
  }
  const auto worldStep = static_cast<float>(ways[0].step * worldPerData_);
  for (int x = 0; x < count; ++x)
  {
    transmittance[x] = std::exp(-worldStep * (depth[x] + partOfLastStep({ x, y, z }, ways[x])));
  }
}

std::size_t ShadowLattice::byteSize() const noexcept
{
  std::size_t bytes = isVisible_.capacity() + extinctions_.capacity() * sizeof(float);
  for (const LargeVector<float>& transmittance : transmittances_)
  {
    bytes += transmittance.capacity() * sizeof(float);
  }
  return bytes;
}

} // namespace treeamr
