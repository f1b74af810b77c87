// The rays stage of the volume kernel: a tile's 16 x 16 rays, their drawn parts, their translucent hits and what they
// have gathered. Compiled once for each instruction set, as Highway wants it.
#if defined(TREEAMR_VOLUMERAYS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_VOLUMERAYS_INL_H
#undef TREEAMR_VOLUMERAYS_INL_H
#else
#define TREEAMR_VOLUMERAYS_INL_H
#endif

#include "Volume/Kernel/VolumeKernel.h"
#include "Volume/Kernel/VolumeSampling-inl.h"

#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

constexpr int groupRays = 16;
constexpr int groups = 16;
constexpr int tileRays = groups * groupRays;
static_assert(volumeTileWidth * volumeTileWidth == tileRays);
/// Bit g: group g.
using GroupMask = std::uint32_t;

/// Where rays start.
enum class RayOrigins
{
  Common, // at the scene's reference
  Any,
  Either // as the scene tells; counted as any are
};

/// Real: of lanes.
template <class Real, RayOrigins Origins>
class TileRays
{
public:
  static constexpr bool startAtReference = Origins == RayOrigins::Common;
  static constexpr Real infinity = std::numeric_limits<Real>::infinity();
  static constexpr Real finished = -std::numeric_limits<Real>::max();

  explicit TileRays(const VolumeKernelScene& scene)
    : hasHits_(scene.stops.hits.has_value())
    , opaque_(1.f - scene.settings.leastTransmittance)
    , scene_(scene)
    , width_(scene.camera.width())
    , height_(scene.camera.height())
  {
  }

  /// Rays of a group are 4 x 4 neighbours, groups 4 x 4 in the tile.
  static constexpr int xInTile(int ray) { return 4 * (ray >> 4 & 3) + (ray & 3); }
  static constexpr int yInTile(int ray) { return 4 * (ray >> 6) + (ray >> 2 & 3); }
  static constexpr int groupInTile(int x, int y) { return x / 4 + y / 4 * 4; }

  Real toKernel(int axis, double data) const noexcept
  {
    return static_cast<Real>((data - scene_.reference[axis]) * scene_.dataScale);
  }

  /// Starts with those of the tile at (x0, y0); the groups of which a ray has a part to draw.
  GroupMask makeRays(int x0, int y0)
  {
    if constexpr (Origins != RayOrigins::Any)
    {
      if (isFan())
      {
        makeFan(x0, y0);
      }
    }
    parts_ = 1;
    const bool isCut = hasHits_ || !scene_.stops.cut.isEmpty() || scene_.features.slices;
    GroupMask active = 0;
    for (int r = 0; r < tileRays; ++r)
    {
      red_[r] = green_[r] = blue_[r] = opacity_[r] = 0;
      const int x = x0 + xInTile(r);
      const int y = y0 + yInTile(r);
      nextHitT_[r] = infinity;
      for (int part = 1; part < parts_; ++part)
      {
        end_[part][r] = finished;
      }
      if (x >= width_ || y >= height_ || (scene_.goesOn && !goOn(r, x, y)))
      {
        end_[0][r] = finished;
        continue;
      }
      if (isFan() && !isCut && !scene_.stops.beginDepth && !scene_.stops.endDepth)
      {
        active |= GroupMask(1) << r / groupRays;
        ++drawnRays_;
        continue;
      }
      const std::size_t pixel = static_cast<std::size_t>(y) * width_ + x;
      const double begin = scene_.stops.beginDepth ? scene_.stops.beginDepth[pixel] : 0.;
      const double end = scene_.stops.endDepth ? scene_.stops.endDepth[pixel] : 1.;
      if (!(begin < end))
      {
        end_[0][r] = finished;
        continue;
      }
      if (isFan())
      {
        begin_[0][r] = fanT(x, y, begin);
        end_[0][r] = fanT(x, y, end);
      }
      else
      {
        makeRay(r, x, y, begin, end);
      }
      if (isCut)
      {
        cut(r, x, y);
      }
      if (end_[0][r] != finished)
      {
        active |= GroupMask(1) << r / groupRays;
        ++drawnRays_;
      }
    }
    return active;
  }

  void store(int ray, float* rgba) const noexcept
  {
    rgba[0] = static_cast<float>(red_[ray]);
    rgba[1] = static_cast<float>(green_[ray]);
    rgba[2] = static_cast<float>(blue_[ray]);
    rgba[3] = static_cast<float>(std::min<Real>(opacity_[ray], 1));
  }

  /// All of the tile's, in an image's rows.
  void storeAll(int x0, int y0, float* rgba) const noexcept
  {
    for (int r = 0; r < tileRays; ++r)
    {
      const int x = x0 + xInTile(r);
      const int y = y0 + yInTile(r);
      if (x < width_ && y < height_)
      {
        store(r, rgba + 4 * (static_cast<std::size_t>(y) * width_ + x));
      }
    }
  }

  HWY_INLINE Reals<Real> planeT(int axis, int ray, Real plane) const
  {
    const RealTag<Real> d;
    Reals<Real> distance = hn::Set(d, plane);
    if (!startAtReference)
    {
      distance = hn::Sub(distance, hn::Load(d, origin_[axis] + ray));
    }
    return hn::Mul(distance, hn::Load(d, inverse_[axis] + ray));
  }

  /// Narrows parts of rays to a box.
  HWY_INLINE void enterBox(const Box<Real>& box, int ray, Reals<Real>& begin, Reals<Real>& end) const
  {
    for (int a = 0; a < 3; ++a)
    {
      const Reals<Real> low = planeT(a, ray, box.min[a]);
      const Reals<Real> high = planeT(a, ray, box.max[a]);
      begin = hn::Max(begin, hn::Min(low, high));
      end = hn::Min(end, hn::Max(low, high));
    }
  }

  /// For each of a node's children the groups of which a ray crosses it.
  HWY_INLINE void crossChildren(
    const Box<Real>& box, const std::array<Real, 3>& middle, GroupMask active, GroupMask (&children)[8]) const
  {
    parts_ == 1 ? cross<true>(box, middle, active, children) : crossParts(box, middle, active, children);
  }

  /// Takes the rays from `ray` on across the hits that they have come to before `end`; false when there are none. begin
  /// and end: of what is left.
  HWY_INLINE bool crossHits(int part, int ray, Reals<Real>& begin, Reals<Real>& end)
  {
    const RealTag<Real> d;
    const Reals<Real> hit = hn::Load(d, nextHitT_ + ray);
    const Mask<Real> meets = hn::And(hn::Lt(begin, end), hn::Lt(hit, end));
    if (hn::AllFalse(d, meets))
    {
      return false;
    }
    std::uint8_t bits[(lanes<Real> + 7) / 8] = {};
    hn::StoreMaskBits(d, meets, bits);
    for (int i = 0; i < lanes<Real>; ++i)
    {
      if (bits[i / 8] >> i % 8 & 1)
      {
        crossHit(ray + i);
      }
    }
    begin = hn::IfThenElse(meets, hn::Max(begin, hit), end); // the other rays are through
    end = hn::Min(end, hn::Load(d, end_[part] + ray));       // a ray may be finished
    return true;
  }

  /// After the walk: the hits that no block was visited behind.
  void crossLastHits() noexcept
  {
    for (int r = 0; hasHits_ && r < tileRays; ++r)
    {
      while (nextHitT_[r] < infinity)
      {
        crossHit(r);
      }
    }
  }

  /// Behind the tile's rays there is room for a vector of packed ones.
  static constexpr int packed = tileRays;
  static constexpr int slots = tileRays + lanes<Real>;

  HWY_ALIGN Real origin_[3][slots] = {}; // zero in a fan
  HWY_ALIGN Real direction_[3][slots] = {};
  HWY_ALIGN Real inverse_[3][tileRays] = {};
  HWY_ALIGN Real begin_[RayParts::most][slots] = {};
  HWY_ALIGN Real end_[RayParts::most][slots] = {};
  HWY_ALIGN Real lengthPerT_[slots] = {}; // of the world, in diagonals of the domain in data coordinates
  HWY_ALIGN Real red_[slots];
  HWY_ALIGN Real green_[slots];
  HWY_ALIGN Real blue_[slots];
  HWY_ALIGN Real opacity_[slots];
  int parts_ = 1; // of begin_ and end_ in use: the most of any ray
  bool hasHits_;
  Real opaque_;                       // a ray with more opacity is done
  HWY_ALIGN Real nextHitT_[tileRays]; // with hits only; infinite: none
  std::uint64_t drawnRays_ = 0;       // of all tiles so far

private:
  /// Whether the rays are made from the scene's fan.
  bool isFan() const noexcept
  {
    return Origins == RayOrigins::Either ? scene_.features.commonOrigin : startAtReference;
  }

  /// Starts the ray with what the image has of it; whether it has light left.
  HWY_NOINLINE bool goOn(int r, int x, int y) noexcept
  {
    const float* const rgba = scene_.image->rgba.data() + 4 * (static_cast<std::size_t>(y) * width_ + x);
    red_[r] = rgba[0];
    green_[r] = rgba[1];
    blue_[r] = rgba[2];
    opacity_[r] = rgba[3];
    return !(opacity_[r] > opaque_);
  }

  /// Finds the ray's hits, and leaves its parts, or where it meets the slice.
  void cut(int r, int x, int y)
  {
    if (hasHits_)
    {
      const std::size_t pixel = static_cast<std::size_t>(y) * width_ + x;
      nextHit_[r] = scene_.stops.hits->first[pixel];
      endOfHits_[r] = scene_.stops.hits->first[pixel + 1];
      while (nextHit_[r] != endOfHits_[r] && hitT(r, nextHit_[r]) < begin_[0][r])
      {
        ++nextHit_[r];
      }
      while (nextHit_[r] != endOfHits_[r] && !(hitT(r, endOfHits_[r] - 1) < end_[0][r]))
      {
        --endOfHits_[r];
      }
      findHit(r);
    }
    if (!scene_.stops.cut.isEmpty())
    {
      const RayParts parts = isFan() ? cutFan(r, x, y) : cutRay(r, x, y);
      while (parts_ < parts.count)
      {
        std::fill_n(end_[parts_++], tileRays, finished);
      }
      end_[0][r] = finished;
      for (int part = 0; part < parts.count; ++part)
      {
        begin_[part][r] = tToKernel(parts.begin[part]);
        end_[part][r] = tToKernel(parts.end[part]);
      }
    }
    if (scene_.features.slices)
    {
      slice(r, x, y);
    }
  }

  RayParts cutFan(int r, int x, int y) const noexcept
  {
    return scene_.stops.cut.parts(
      scene_.reference, fanDirection(x, y), begin_[0][r] / scene_.scale, end_[0][r] / scene_.scale);
  }

  Vec3 fanDirection(int x, int y) const noexcept
  {
    const PixelFan& fan = scene_.fan;
    Vec3 direction;
    for (int a = 0; a < 3; ++a)
    {
      direction[a] = fan.direction[a] + x * fan.perX[a] + y * fan.perY[a];
    }
    return direction;
  }

  /// Leaves of the ray's parts no more than what begins in the plane: no plane between nodes fits into it. Where cells meet
  /// in the plane, what is on both sides of it: the first that there is ends the ray.
  HWY_NOINLINE void slice(int r, int x, int y) noexcept
  {
    const auto& [normal, offset] = scene_.settings.slice;
    const Ray ray = isFan() ? Ray{ scene_.reference, fanDirection(x, y) } : scene_.camera.ray(x, y);
    const Real at = tToKernel((offset - dot(normal, ray.origin)) / dot(normal, ray.direction));
    bool isMet = false; // NaN is no place
    for (int part = 0; part < parts_; ++part)
    {
      isMet = isMet || (begin_[part][r] <= at && at < end_[part][r]);
      end_[part][r] = finished;
    }
    if (!isMet)
    {
      return;
    }
    if (!scene_.features.slicesFaces)
    {
      begin_[0][r] = at;
      end_[0][r] = std::nextafter(at, infinity);
      return;
    }
    while (parts_ < 2)
    {
      std::fill_n(end_[parts_++], tileRays, finished);
    }
    // Of places of planes and on the ray; of a far eye's rays in doubles, too.
    constexpr Real rounding = std::is_same_v<Real, float> ? 0x1p-21 : 0x1p-30;
    const double speed = std::abs(dot(normal, ray.direction)) / std::sqrt(dot(normal, normal));
    const Real side = rounding * std::max(std::abs(at), Real(1)) *
      static_cast<Real>(scene_.scale / (scene_.dataScale * speed));
    for (int part = 0; part < 2; ++part)
    {
      begin_[part][r] = part == 0 ? at - side : at + side;
      end_[part][r] = std::nextafter(begin_[part][r], infinity);
    }
  }

  RayParts cutRay(int r, int x, int y) const noexcept
  {
    const Ray ray = scene_.camera.ray(x, y);
    return scene_.stops.cut.parts(ray.origin, ray.direction, begin_[0][r] / scene_.scale + scene_.tReference,
      end_[0][r] / scene_.scale + scene_.tReference);
  }

  void findHit(int r) noexcept
  {
    nextHitT_[r] = nextHit_[r] != endOfHits_[r] ? hitT(r, nextHit_[r]) : infinity;
  }

  /// Takes a ray across the hit that it has come to.
  HWY_NOINLINE void crossHit(int r) noexcept
  {
    const std::array<float, 4>& rgba = scene_.stops.hits->hits[nextHit_[r]].rgba;
    const Real weight = opacity_[r] > opaque_ ? 0 : (1 - opacity_[r]) * rgba[3];
    red_[r] += weight * rgba[0];
    green_[r] += weight * rgba[1];
    blue_[r] += weight * rgba[2];
    opacity_[r] += weight;
    for (int part = 0; opacity_[r] > opaque_ && part < parts_; ++part)
    {
      end_[part][r] = finished;
    }
    ++nextHit_[r];
    findHit(r);
  }

  Real fanT(int x, int y, double depth) const noexcept
  {
    const PixelFan& fan = scene_.fan;
    return static_cast<Real>(scene_.scale /
      (fan.inverseT + x * fan.inverseTPerX + y * fan.inverseTPerY + depth * fan.inverseTPerDepth));
  }

  /// A ray parallel to a face has no reciprocal: this slope sorts it into one side of any plane.
  static constexpr Real tiny = 1e-20;

  /// Away from zero, keeping its sign.
  static HWY_INLINE Reals<Real> awayFromZero(Reals<Real> v)
  {
    const RealTag<Real> d;
    return hn::CopySign(hn::Max(hn::Abs(v), hn::Set(d, tiny)), v);
  }

  void makeFan(int x0, int y0)
  {
    const RealTag<Real> d;
    const PixelFan& fan = scene_.fan;
    HWY_ALIGN static constexpr Real xs[groupRays] = { 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3 };
    HWY_ALIGN static constexpr Real ys[groupRays] = { 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3 };
    const Matrix4& m = scene_.camera.worldFromData();
    const double toKernel = scene_.dataScale / scene_.scale; // of slopes
    for (int ray = 0; ray < tileRays; ray += lanes<Real>)
    {
      const Reals<Real> x = hn::Load(d, xs + ray % groupRays);
      const Reals<Real> y = hn::Load(d, ys + ray % groupRays);
      const int groupX = x0 + xInTile(ray & ~(groupRays - 1));
      const int groupY = y0 + yInTile(ray & ~(groupRays - 1));
      Reals<Real> direction[3];
      for (int a = 0; a < 3; ++a)
      {
        const double first = toKernel * (fan.direction[a] + groupX * fan.perX[a] + groupY * fan.perY[a]);
        direction[a] = mulAdd(x, hn::Set(d, static_cast<Real>(toKernel * fan.perX[a])),
          mulAdd(
            y, hn::Set(d, static_cast<Real>(toKernel * fan.perY[a])), hn::Set(d, static_cast<Real>(first))));
        hn::Store(direction[a], d, direction_[a] + ray);
        hn::Store(hn::Div(hn::Set(d, Real(1)), awayFromZero(direction[a])), d, inverse_[a] + ray);
      }
      Reals<Real> squared = hn::Zero(d);
      for (int r = 0; r < 3; ++r)
      {
        Reals<Real> w = hn::Zero(d);
        for (int a = 0; a < 3; ++a)
        {
          w = mulAdd(hn::Set(d, static_cast<Real>(m[4 * r + a])), direction[a], w);
        }
        squared = mulAdd(w, w, squared);
      }
      hn::Store(hn::Sqrt(squared), d, lengthPerT_ + ray);
      const Reals<Real> perX = hn::Set(d, static_cast<Real>(fan.inverseTPerX / scene_.scale));
      const Reals<Real> perY = hn::Set(d, static_cast<Real>(fan.inverseTPerY / scene_.scale));
      const double first =
        (fan.inverseT + groupX * fan.inverseTPerX + groupY * fan.inverseTPerY) / scene_.scale;
      const Reals<Real> near = mulAdd(x, perX, mulAdd(y, perY, hn::Set(d, static_cast<Real>(first))));
      const Reals<Real> far = mulAdd(
        x, perX, mulAdd(y, perY, hn::Set(d, static_cast<Real>(first + fan.inverseTPerDepth / scene_.scale))));
      hn::Store(hn::Div(hn::Set(d, Real(1)), near), d, begin_[0] + ray);
      hn::Store(hn::Div(hn::Set(d, Real(1)), far), d, end_[0] + ray);
    }
  }

  void makeRay(int r, int x, int y, double begin, double end)
  {
    const Ray ray = scene_.camera.ray(x, y);
    const Bounds domain = scene_.field.octree().grid().bounds();
    begin_[0][r] = tToKernel(scene_.camera.tFromDepth(ray, begin));
    end_[0][r] = tToKernel(scene_.camera.tFromDepth(ray, end));
    lengthPerT_[r] = static_cast<Real>(scene_.dataScale / scene_.scale);
    for (int a = 0; a < 3; ++a)
    {
      const auto slope = static_cast<Real>(ray.direction[a] * scene_.dataScale / scene_.scale);
      direction_[a][r] = slope;
      origin_[a][r] = toKernel(a, ray.origin[a] + scene_.tReference * ray.direction[a]);
      inverse_[a][r] = 1 / (slope >= 0 ? std::max(slope, tiny) : std::min(slope, -tiny));
      if (slope == 0)
      {
        // Beside the planes that it may run in: above them, below the domain's upper face.
        const Real aside = std::numeric_limits<Real>::epsilon() * std::max<Real>(1, std::abs(origin_[a][r]));
        origin_[a][r] += origin_[a][r] < toKernel(a, domain.max[a]) ? aside : -aside;
      }
    }
  }

  Real tToKernel(double t) const noexcept
  {
    return static_cast<Real>((t - scene_.tReference) * scene_.scale);
  }

  /// Where the ray's begin_ and end_ count.
  Real hitT(int r, std::size_t hit) const noexcept
  {
    const double t = scene_.stops.hits->hits[hit].t;
    return isFan() ? static_cast<Real>(t * scene_.dataScale / lengthPerT_[r]) : tToKernel(t);
  }

  /// Groups by child. Where a group is a vector, its lanes are kept until the end: to ask for each vector whether any is
  /// set takes as long as the rest.
  class ChildGroups
  {
  public:
    ChildGroups()
    {
      for (int child = 0; child < 8 && !isVector; ++child)
      {
        words_[child][0] = 0;
      }
    }
    /// isFirst: of the group and child.
    HWY_INLINE void add(int child, int group, Mask<Real> crosses, bool isFirst)
    {
      const RealTag<Real> d;
      if constexpr (isVector)
      {
        std::uint16_t lanesOfGroup = 0;
        hn::StoreMaskBits(d, crosses, reinterpret_cast<std::uint8_t*>(&lanesOfGroup));
        words_[child][group] = isFirst ? lanesOfGroup : words_[child][group] | lanesOfGroup;
      }
      else
      {
        words_[child][0] |= static_cast<std::uint16_t>(!hn::AllFalse(d, crosses) << group);
      }
    }
    /// active: groups that have been added.
    HWY_INLINE GroupMask of(int child, GroupMask active) const
    {
      std::uint16_t mask = words_[child][0];
      if constexpr (isVector)
      {
        const hn::CappedTag<std::uint16_t, groups> d;
        hn::StoreMaskBits(
          d, hn::Ne(hn::Load(d, words_[child]), hn::Zero(d)), reinterpret_cast<std::uint8_t*>(&mask));
      }
      return mask & active;
    }

  private:
    static constexpr bool isVector = lanes<Real> == groupRays;
    HWY_ALIGN std::uint16_t words_[8][isVector ? groups : 1]; // of groups that are not added: anything
  };

  /// For each of a node's children the groups of which a ray crosses it. OnePart: no ray of the tile has more.
  template <bool OnePart>
  HWY_INLINE void cross(
    const Box<Real>& box, const std::array<Real, 3>& middle, GroupMask active, GroupMask (&children)[8]) const
  {
    const RealTag<Real> d;
    ChildGroups crossing;
    for (GroupMask rest = active; rest != 0; rest &= rest - 1)
    {
      const int group = std::countr_zero(rest);
      for (int ray = group * groupRays; ray < (group + 1) * groupRays; ray += lanes<Real>)
      {
        Reals<Real> begin[3][2];
        Reals<Real> end[3][2];
        for (int a = 0; a < 3; ++a)
        {
          const Reals<Real> low = planeT(a, ray, box.min[a]);
          const Reals<Real> mid = planeT(a, ray, middle[a]);
          const Reals<Real> high = planeT(a, ray, box.max[a]);
          begin[a][0] = hn::Min(low, mid);
          end[a][0] = hn::Max(low, mid);
          begin[a][1] = hn::Min(mid, high);
          end[a][1] = hn::Max(mid, high);
        }
        for (int part = 0; part < (OnePart ? 1 : parts_); ++part)
        {
          const Reals<Real> rayBegin = hn::Load(d, begin_[part] + ray);
          const Reals<Real> rayEnd = hn::Load(d, end_[part] + ray);
          for (int z = 0; z < 2; ++z)
          {
            const Reals<Real> beginZ = hn::Max(begin[2][z], rayBegin);
            const Reals<Real> endZ = hn::Min(end[2][z], rayEnd);
            for (int y = 0; y < 2; ++y)
            {
              const Reals<Real> beginYZ = hn::Max(begin[1][y], beginZ);
              const Reals<Real> endYZ = hn::Min(end[1][y], endZ);
              for (int x = 0; x < 2; ++x)
              {
                crossing.add(x + 2 * y + 4 * z, group,
                  hn::Lt(hn::Max(begin[0][x], beginYZ), hn::Min(end[0][x], endYZ)), part == 0);
              }
            }
          }
        }
      }
    }
    for (int c = 0; c < 8; ++c)
    {
      children[c] = crossing.of(c, active);
    }
  }

  HWY_NOINLINE void crossParts(
    const Box<Real>& box, const std::array<Real, 3>& middle, GroupMask active, GroupMask (&children)[8]) const
  {
    cross<false>(box, middle, active, children);
  }

  const VolumeKernelScene& scene_;
  int width_;
  int height_;
  std::size_t nextHit_[tileRays];
  std::size_t endOfHits_[tileRays];
};

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif
