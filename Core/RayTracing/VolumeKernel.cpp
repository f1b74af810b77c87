// The volume renderer's inner part, vectorised across rays with Highway and compiled once for each
// instruction set; the best is chosen when the program runs.
//
// A tile of 16 x 16 rays descends the octree once, front to back. Its rays form 16 groups of 4 x 4 pixels, a
// group filling one AVX-512 vector (or 2 or 4 narrower ones), and a node is tested against the groups that
// its parent met. In a leaf all rays of a group are integrated together, from the leaf's 27 vertex values: on
// AVX-512 these stay in three registers and the corners of each ray's octant are permutations of them.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "RayTracing/VolumeKernel.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h: the rest is compiled once for each target.
#include "RayTracing/VolumeKernel.h"

#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

#include <bit>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::CappedTag<float, 16>;
using IntTag = hn::RebindToSigned<FloatTag>;
using Floats = hn::Vec<FloatTag>;
using Ints = hn::Vec<IntTag>;
using Mask = hn::Mask<FloatTag>;

constexpr int lanes = hn::MaxLanes(FloatTag());
constexpr int groupRays = 16;
constexpr int groups = 16;
constexpr int tileRays = groups * groupRays;
static_assert(volumeTileWidth * volumeTileWidth == tileRays);
/// Bit g: group g.
using GroupMask = std::uint32_t;

/// As in the reference: a ray with less light left is done.
constexpr float opaqueTransmittance = 1.f / 1024.f;
constexpr float finished = -std::numeric_limits<float>::max();

struct Box
{
  std::array<float, 3> min;
  std::array<float, 3> max;
};

/// Entry and exit of rays.
struct Intervals
{
  Floats begin;
  Floats end;
};

/// The corners of each ray's octant, by x + 2 y + 4 z.
using Corners = Floats[8];

/// CommonOrigin: all rays start at the scene's reference.
template <bool CommonOrigin>
class Tile
{
public:
  explicit Tile(const VolumeKernelScene& scene) noexcept
    : scene_(scene)
    , octree_(scene.field.octree())
    , grid_(octree_.grid())
    , path_(octree_)
    , writer_(scene.kept)
    , tableMin_(static_cast<float>(scene.transferFunction.min()))
    , tableScale_(static_cast<float>(scene.transferFunction.scale()))
    , tableLast_(static_cast<float>(scene.table.size() - 1))
  {
  }

  void render(int x0, int y0)
  {
    GroupMask active = makeRays(x0, y0);
    const NodeRef root = octree_.root();
    Range rootRange = scene_.field.range();
    if (!root.isNone() && isVisible(root, rootRange))
    {
      path_.reset();
      depth_ = 0;
      index_ = {};
      const Bounds bounds = grid_.nodeBounds(index_, 0);
      Box box;
      for (int a = 0; a < 3; ++a)
      {
        box.min[a] = toKernel(a, bounds.min[a]);
        box.max[a] = toKernel(a, bounds.max[a]);
      }
      active = crossing(box, active);
      if (active != 0)
      {
        root.isLeaf() ? visitLeaf(root, box, active) : visit(root, box, active, rootRange);
      }
    }
    writePixels(x0, y0);
  }

  const VolumeStatistics& statistics() const noexcept { return statistics_; }

private:
  /// Rays of a group are 4 x 4 neighbours, groups 4 x 4 in the tile.
  static constexpr int xInTile(int ray) { return 4 * (ray >> 4 & 3) + (ray & 3); }
  static constexpr int yInTile(int ray) { return 4 * (ray >> 6) + (ray >> 2 & 3); }

  float toKernel(int axis, double data) const noexcept
  {
    return static_cast<float>((data - scene_.reference[axis]) * scene_.scale);
  }

  GroupMask makeRays(int x0, int y0)
  {
    GroupMask active = 0;
    for (int r = 0; r < tileRays; ++r)
    {
      transmittance_[r] = 1.f;
      red_[r] = green_[r] = blue_[r] = 0.f;
      begin_[r] = 0.f;
      end_[r] = finished;
      for (int a = 0; a < 3; ++a)
      {
        origin_[a][r] = 0.f;
        direction_[a][r] = inverse_[a][r] = 1.f;
      }
      const int x = x0 + xInTile(r);
      const int y = y0 + yInTile(r);
      if (x >= scene_.image.width || y >= scene_.image.height)
      {
        continue;
      }
      const std::size_t pixel = static_cast<std::size_t>(y) * scene_.image.width + x;
      const double begin = scene_.interval.begin ? scene_.interval.begin[pixel] : 0.;
      const double end = scene_.interval.end ? scene_.interval.end[pixel] : 1.;
      if (!(begin < end))
      {
        continue;
      }
      const Ray ray = scene_.camera.ray(x, y);
      begin_[r] = tToKernel(scene_.camera.tFromDepth(ray, begin));
      end_[r] = tToKernel(scene_.camera.tFromDepth(ray, end));
      for (int a = 0; a < 3; ++a)
      {
        // A parallel to a face has no reciprocal; this tiny slope sorts it into one side of any plane.
        constexpr float tiny = 1e-20f;
        const auto d = static_cast<float>(ray.direction[a]);
        direction_[a][r] = d;
        inverse_[a][r] = 1.f / (d >= 0.f ? std::max(d, tiny) : std::min(d, -tiny));
        if (!CommonOrigin)
        {
          origin_[a][r] = toKernel(a, ray.origin[a] + scene_.tReference * ray.direction[a]);
        }
      }
      active |= GroupMask(1) << r / groupRays;
    }
    return active;
  }

  float tToKernel(double t) const noexcept
  {
    return static_cast<float>((t - scene_.tReference) * scene_.scale);
  }

  void writePixels(int x0, int y0) const noexcept
  {
    for (int r = 0; r < tileRays; ++r)
    {
      const int x = x0 + xInTile(r);
      const int y = y0 + yInTile(r);
      if (x < scene_.image.width && y < scene_.image.height)
      {
        float* rgba = scene_.image.rgba.data() + 4 * (static_cast<std::size_t>(y) * scene_.image.width + x);
        rgba[0] = red_[r];
        rgba[1] = green_[r];
        rgba[2] = blue_[r];
        rgba[3] = 1.f - transmittance_[r];
      }
    }
  }

  /// range: the parent's, and the node's on return.
  bool isVisible(NodeRef node, Range& range) const noexcept
  {
    if (!node.isInner() || !scene_.settings.skipEmpty)
    {
      return true;
    }
    range = scene_.field.nodeRange(node, range);
    return scene_.transferFunction.isVisible(range);
  }

  HWY_INLINE void clipAxis(int axis, int ray, const Box& box, Intervals& t) const
  {
    const FloatTag d;
    const Floats inverse = hn::Load(d, inverse_[axis] + ray);
    Floats low = hn::Set(d, box.min[axis]);
    Floats high = hn::Set(d, box.max[axis]);
    if (!CommonOrigin)
    {
      const Floats origin = hn::Load(d, origin_[axis] + ray);
      low = hn::Sub(low, origin);
      high = hn::Sub(high, origin);
    }
    low = hn::Mul(low, inverse);
    high = hn::Mul(high, inverse);
    t.begin = hn::Max(t.begin, hn::Min(low, high));
    t.end = hn::Min(t.end, hn::Max(low, high));
  }

  HWY_INLINE Intervals clip(int ray, const Box& box) const
  {
    const FloatTag d;
    Intervals t{ hn::Load(d, begin_ + ray), hn::Load(d, end_ + ray) };
    clipAxis(0, ray, box, t);
    clipAxis(1, ray, box, t);
    clipAxis(2, ray, box, t);
    return t;
  }

  /// Those of the groups of which a ray crosses the box.
  HWY_INLINE GroupMask crossing(const Box& box, GroupMask active) const
  {
    const FloatTag d;
    GroupMask out = 0;
    for (; active != 0; active &= active - 1)
    {
      const int group = std::countr_zero(active);
      bool any = false;
      for (int ray = group * groupRays; ray < (group + 1) * groupRays; ray += lanes)
      {
        const Intervals t = clip(ray, box);
        any = any || !hn::AllFalse(d, hn::Lt(t.begin, t.end));
      }
      out |= static_cast<GroupMask>(any) << group;
    }
    return out;
  }

  void visit(NodeRef node, const Box& box, GroupMask active, Range range)
  {
    ++statistics_.nodes;
    std::array<float, 3> middle;
    int nearest = 0;
    for (int a = 0; a < 3; ++a)
    {
      const double plane = grid_.nodePlane(a, 2 * index_[a] + 1, depth_ + 1);
      middle[a] = toKernel(a, plane);
      const bool upper =
        scene_.camera.isPerspective() ? scene_.camera.eye()[a] >= plane : direction_[a][0] < 0.f;
      nearest |= upper << a;
    }
    for (int i = 0; i < 8; ++i)
    {
      const int octant = i ^ nearest;
      const NodeRef child = octree_.child(node, octant);
      Range childRange = range;
      if (child.isNone() || !isVisible(child, childRange))
      {
        continue;
      }
      Box childBox;
      for (int a = 0; a < 3; ++a)
      {
        const bool upper = octant >> a & 1;
        childBox.min[a] = upper ? middle[a] : box.min[a];
        childBox.max[a] = upper ? box.max[a] : middle[a];
      }
      const GroupMask childActive = crossing(childBox, active);
      if (childActive == 0)
      {
        continue;
      }
      octant_[depth_] = static_cast<std::uint8_t>(octant);
      const auto index = index_;
      for (int a = 0; a < 3; ++a)
      {
        index_[a] = 2 * index_[a] + (octant >> a & 1);
      }
      ++depth_;
      child.isLeaf() ? visitLeaf(child, childBox, childActive)
                     : visit(child, childBox, childActive, childRange);
      --depth_;
      index_ = index;
      if (path_.depth() > depth_)
      {
        path_.ascend();
      }
    }
  }

  /// Kept, or computed: only then are the neighbourhoods down to here needed.
  const VertexRecord& vertices(NodeRef leaf)
  {
    if (const VertexRecord* found = scene_.kept.find(leaf.index()))
    {
      return *found;
    }
    ++statistics_.cells;
    while (path_.depth() < depth_)
    {
      path_.descend(octant_[path_.depth()]);
    }
    VertexRecord* record = writer_.reserve();
    if (!record)
    {
      local_.compute(path_, scene_.field, memo_);
      return local_;
    }
    record->compute(path_, scene_.field, memo_);
    writer_.publish(leaf.index());
    return *record;
  }

  void visitLeaf(NodeRef leaf, const Box& box, GroupMask active)
  {
    if (octree_.isGhost(leaf.index()))
    {
      return;
    }
    const VertexRecord& record = vertices(leaf);
    if (scene_.settings.skipEmpty && !scene_.transferFunction.isVisible(record.range))
    {
      return;
    }
    const LeafValues values(record);
    for (; active != 0; active &= active - 1)
    {
      const int group = std::countr_zero(active);
      for (int ray = group * groupRays; ray < (group + 1) * groupRays; ray += lanes)
      {
        integrate(ray, box, values);
      }
    }
  }

  /// A leaf's vertex values, ready for look-ups by ray.
  class LeafValues
  {
  public:
    HWY_INLINE explicit LeafValues(const VertexRecord& record)
      : vertices(record.values.data())
      , range(record.range)
    {
      if constexpr (lanes == 16)
      {
        const FloatTag d;
        plane[0] = hn::LoadU(d, vertices);
        plane[1] = hn::LoadU(d, vertices + 9);
        plane[2] = hn::LoadU(d, vertices + 16); // two lanes on: no load reaches beyond the record
        alignas(
          64) static constexpr std::int32_t shift[16] = { 2, 3, 4, 5, 6, 7, 8, 9, 10, 0, 0, 0, 0, 0, 0, 0 };
        plane[2] = hn::TableLookupLanes(plane[2], hn::SetTableIndices(d, shift));
      }
    }

    /// base: x + 3 y of the octant's lower corner. upperZ: whether it is one of the upper octants.
    HWY_INLINE void corners(Ints base, Mask upperZ, Corners& out) const
    {
      const FloatTag d;
      const IntTag di;
      constexpr std::int32_t offset[4] = { 0, 1, 3, 4 };
      for (int c = 0; c < 4; ++c)
      {
        const Ints at = hn::Add(base, hn::Set(di, offset[c]));
        if constexpr (lanes == 16)
        {
          const auto lane = hn::IndicesFromVec(d, at);
          const Floats low = hn::TableLookupLanes(plane[0], lane);
          const Floats mid = hn::TableLookupLanes(plane[1], lane);
          const Floats high = hn::TableLookupLanes(plane[2], lane);
          out[c] = hn::IfThenElse(upperZ, mid, low);
          out[c + 4] = hn::IfThenElse(upperZ, high, mid);
        }
        else
        {
          const Ints index = hn::Add(at, hn::IfThenElseZero(hn::RebindMask(di, upperZ), hn::Set(di, 9)));
          out[c] = hn::GatherIndex(d, vertices, index);
          out[c + 4] = hn::GatherIndex(d, vertices + 9, index);
        }
      }
    }

    const float* vertices;
    Range range;
    Floats plane[3]; // z = 0, 1, 2; in 16 lanes only
  };

  /// Position along an axis in half widths (0 to 2) as octant and position in it (0 to 1).
  static HWY_INLINE Mask splitOctant(Floats& position)
  {
    const FloatTag d;
    const Floats one = hn::Set(d, 1.f);
    const Mask upper = hn::Ge(position, one);
    position = hn::Sub(position, hn::IfThenElseZero(upper, one));
    position = hn::Min(one, hn::Max(hn::Zero(d), position));
    return upper;
  }

  static HWY_INLINE Floats lerp(Floats f, Floats a, Floats b) { return hn::MulAdd(f, hn::Sub(b, a), a); }

  static HWY_INLINE Floats fieldAt(Floats x, Floats y, Floats z, const LeafValues& values)
  {
    const FloatTag d;
    const IntTag di;
    const Mask upperX = splitOctant(x);
    const Mask upperY = splitOctant(y);
    const Mask upperZ = splitOctant(z);
    const Ints base = hn::Add(hn::IfThenElseZero(hn::RebindMask(di, upperX), hn::Set(di, 1)),
      hn::IfThenElseZero(hn::RebindMask(di, upperY), hn::Set(di, 3)));
    Corners v;
    values.corners(base, upperZ, v);
    const Floats low = lerp(y, lerp(x, v[0], v[1]), lerp(x, v[2], v[3]));
    const Floats high = lerp(y, lerp(x, v[4], v[5]), lerp(x, v[6], v[7]));
    // Rounding must not leave the range by which nodes are skipped.
    return hn::Min(hn::Set(d, values.range.max), hn::Max(hn::Set(d, values.range.min), lerp(z, low, high)));
  }

  HWY_INLINE Ints tableIndex(Floats value) const
  {
    const FloatTag d;
    const Floats position = hn::Mul(hn::Sub(value, hn::Set(d, tableMin_)), hn::Set(d, tableScale_));
    const Floats clamped = hn::Min(hn::Set(d, tableLast_), hn::Max(hn::Zero(d), position));
    return hn::ShiftLeft<2>(hn::NearestInt(clamped)); // entries of four floats
  }

  /// Midpoint samples of the rays from `ray` on, as many for each as its way through the leaf asks for.
  HWY_INLINE void integrate(int ray, const Box& box, const LeafValues& values)
  {
    const FloatTag d;
    const Intervals t = clip(ray, box);
    const Mask crosses = hn::Lt(t.begin, t.end);
    if (hn::AllFalse(d, crosses))
    {
      return;
    }
    const Floats length = hn::IfThenElseZero(crosses, hn::Sub(t.end, t.begin));
    Floats at[3];    // in half widths
    Floats slope[3]; // per kernel unit
    Floats squared = hn::Zero(d);
    for (int a = 0; a < 3; ++a)
    {
      const Floats direction = hn::Load(d, direction_[a] + ray);
      const Floats halfWidths = hn::Set(d, 2.f / (box.max[a] - box.min[a]));
      Floats start = hn::Set(d, -box.min[a]);
      if (!CommonOrigin)
      {
        start = hn::Add(start, hn::Load(d, origin_[a] + ray));
      }
      at[a] = hn::Mul(hn::MulAdd(t.begin, direction, start), halfWidths);
      slope[a] = hn::Mul(direction, halfWidths);
      squared = hn::MulAdd(slope[a], slope[a], squared);
    }
    const Floats widths = hn::Mul(hn::Mul(hn::Sqrt(squared), length), hn::Set(d, 0.5f));
    const Floats samples = hn::Max(hn::Set(d, 1.f),
      hn::Ceil(hn::Mul(widths, hn::Set(d, static_cast<float>(scene_.settings.samplesPerCell)))));
    const Floats step = hn::Div(length, samples);
    const float mostSamples = hn::GetLane(hn::MaxOfLanes(d, hn::IfThenElseZero(crosses, samples)));

    const float* const table = &scene_.table.data()->r;
    Floats transmittance = hn::Load(d, transmittance_ + ray);
    Floats red = hn::Load(d, red_ + ray);
    Floats green = hn::Load(d, green_ + ray);
    Floats blue = hn::Load(d, blue_ + ray);
    for (float i = 0.5f; i < mostSamples; i += 1.f)
    {
      const Floats along = hn::Mul(hn::Set(d, i), step);
      const Mask live = hn::Lt(along, length);
      statistics_.samples += hn::CountTrue(d, live);
      const Ints entry = tableIndex(fieldAt(hn::MulAdd(along, slope[0], at[0]),
        hn::MulAdd(along, slope[1], at[1]), hn::MulAdd(along, slope[2], at[2]), values));
      const Floats extinction = hn::IfThenElseZero(live, hn::GatherIndex(d, table + 3, entry));
      if (hn::AllTrue(d, hn::Eq(extinction, hn::Zero(d))))
      {
        continue;
      }
      const Floats passes = hn::Exp(d, hn::Neg(hn::Mul(extinction, step)));
      const Floats weight = hn::NegMulAdd(transmittance, passes, transmittance);
      red = hn::MulAdd(weight, hn::GatherIndex(d, table, entry), red);
      green = hn::MulAdd(weight, hn::GatherIndex(d, table + 1, entry), green);
      blue = hn::MulAdd(weight, hn::GatherIndex(d, table + 2, entry), blue);
      transmittance = hn::Mul(transmittance, passes);
    }
    hn::Store(transmittance, d, transmittance_ + ray);
    hn::Store(red, d, red_ + ray);
    hn::Store(green, d, green_ + ray);
    hn::Store(blue, d, blue_ + ray);
    const Mask opaque = hn::Lt(transmittance, hn::Set(d, opaqueTransmittance));
    hn::Store(hn::IfThenElse(opaque, hn::Set(d, finished), hn::Load(d, end_ + ray)), d, end_ + ray);
  }

  const VolumeKernelScene& scene_;
  const Octree& octree_;
  const RootGrid& grid_;
  TreePath path_; // as deep as neighbourhoods were needed so far
  VertexMemo memo_;
  VertexCache::Writer writer_;
  VertexRecord local_;
  float tableMin_;
  float tableScale_;
  float tableLast_;

  int depth_ = 0;
  std::array<Coord, 3> index_{};
  std::array<std::uint8_t, Octree::maxDepth + 1> octant_;

  HWY_ALIGN float origin_[3][tileRays];
  HWY_ALIGN float direction_[3][tileRays];
  HWY_ALIGN float inverse_[3][tileRays];
  HWY_ALIGN float begin_[tileRays];
  HWY_ALIGN float end_[tileRays];
  HWY_ALIGN float transmittance_[tileRays];
  HWY_ALIGN float red_[tileRays];
  HWY_ALIGN float green_[tileRays];
  HWY_ALIGN float blue_[tileRays];
  VolumeStatistics statistics_;
};

template <bool CommonOrigin>
VolumeStatistics renderRow(const VolumeKernelScene& scene, int row, int columnBegin, int columnEnd)
{
  Tile<CommonOrigin> tile(scene);
  for (int column = columnBegin; column < columnEnd; ++column)
  {
    tile.render(column * volumeTileWidth, row * volumeTileWidth);
  }
  return tile.statistics();
}

VolumeStatistics RenderTiles(const VolumeKernelScene& scene, int row, int columnBegin, int columnEnd)
{
  return scene.commonOrigin ? renderRow<true>(scene, row, columnBegin, columnEnd)
                            : renderRow<false>(scene, row, columnBegin, columnEnd);
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeamr
{

HWY_EXPORT(RenderTiles);

VolumeStatistics renderVolumeTiles(const VolumeKernelScene& scene, int row, int columnBegin, int columnEnd)
{
  return HWY_DYNAMIC_DISPATCH(RenderTiles)(scene, row, columnBegin, columnEnd);
}

} // namespace treeamr
#endif
