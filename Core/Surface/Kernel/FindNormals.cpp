// The gradients and normals at many hits: gradientAt() and normalAt() for vectors of them.
#include "InstructionSets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Surface/Kernel/FindNormals.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h: the rest is compiled once for each target.
#include "Surface/Kernel/SurfaceKernel.h"
#include "Surface/Kernel/SurfaceVectors-inl.h"

#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

HWY_INLINE Doubles along(Doubles low, Doubles high, Doubles part)
{
  return hn::Add(low, hn::Mul(part, hn::Sub(high, low)));
}

/// Where vectors of three fit one register.
constexpr bool holdsThree = hn::MaxLanes(hn::CappedTag<double, 4>()) == 4;

/// normalAt() but for its length: all three axes at once.
HWY_INLINE void interpolate(const HitPlaces& hits, int i, std::array<HitPlaces::Component, 3>& normal)
{
  const GradientRecord::Vertex* corners = hits.vertexGradients[i];
  constexpr auto& stride = block::vertexStride;
  if constexpr (holdsThree)
  {
    const hn::CappedTag<double, 4> d;
    const hn::Rebind<float, decltype(d)> df;
    const auto three = hn::FirstN(df, 3);
    const auto at = [&](int vertex) {
      return hn::PromoteTo(d, hn::MaskedLoad(three, df, corners[vertex].data()));
    };
    const auto along = [](auto low, auto high, auto part) {
      return hn::Add(low, hn::Mul(part, hn::Sub(high, low)));
    };
    const auto x = hn::Set(d, hits.place[0][i]);
    const auto y = hn::Set(d, hits.place[1][i]);
    const auto z = hn::Set(d, hits.place[2][i]);
    const auto onEdge = [&](int first) { return along(at(first), at(first + stride[0]), x); };
    const auto onFace = [&](int first) { return along(onEdge(first), onEdge(first + stride[1]), y); };
    HWY_ALIGN double sum[4];
    hn::Store(along(onFace(0), onFace(stride[2]), z), d, sum);
    for (int a = 0; a < 3; ++a)
    {
      normal[a][i] = sum[a];
    }
  }
  else
  {
    for (int a = 0; a < 3; ++a)
    {
      Corners ofAxis;
      for (int c = 0; c < 8; ++c)
      {
        ofAxis[c] = corners[cornerOffset(c, stride)][a];
      }
      normal[a][i] = trilinear(ofAxis, { hits.place[0][i], hits.place[1][i], hits.place[2][i] });
    }
  }
}

/// Of the octants' edges, by axis and in the order of the next one, the differences along them.
struct EdgeDifferences
{
  alignas(64) std::array<std::array<HitPlaces::Component, 4>, 3> at;

  HWY_INLINE explicit EdgeDifferences(const HitPlaces& hits)
  {
    for (int i = 0; i < hits.count; ++i)
    {
      const double* v = hits.values[i];
      for (int a = 0; a < 3; ++a)
      {
        const int step = block::vertexStride[a];
        const int b = block::vertexStride[(a + 1) % 3];
        const int c = block::vertexStride[(a + 2) % 3];
        at[a][0][i] = v[step] - v[0];
        at[a][1][i] = v[step + b] - v[b];
        at[a][2][i] = v[step + c] - v[c];
        at[a][3][i] = v[step + b + c] - v[b + c];
      }
    }
  }
};

/// 1 / width when that is as good as to divide by it, else 0.
double exactReciprocal(double width)
{
  int exponent;
  const double inverse = 1. / width;
  return std::frexp(width, &exponent) == 0.5 && std::isnormal(inverse) ? inverse : 0.;
}

void FindNormals(const Vec3& width, HitPlaces& hits)
{
  const Tag d;
  const Vec3 perWidth{ exactReciprocal(width[0]), exactReciprocal(width[1]), exactReciprocal(width[2]) };
  const EdgeDifferences differences(hits);
  if (hits.withNormals)
  {
    for (int i = 0; i < hits.count; ++i)
    {
      interpolate(hits, i, hits.normal);
    }
  }
  for (int i = 0; i < hits.count; i += lanes)
  {
    Vectors3 place;
    for (int a = 0; a < 3; ++a)
    {
      place[a] = hn::Load(d, &hits.place[a][i]);
    }
    for (int a = 0; a < 3; ++a)
    {
      const auto at = [&](int edge) { return hn::Load(d, &differences.at[a][edge][i]); };
      const Doubles atB = place[(a + 1) % 3];
      const Doubles difference =
        along(along(at(0), at(1), atB), along(at(2), at(3), atB), place[(a + 2) % 3]);
      const Doubles slope = hn::Mul(difference, hn::Load(d, &hits.inverseWidth[a][i]));
      const Doubles inData =
        perWidth[a] != 0. ? hn::Mul(slope, set(perWidth[a])) : hn::Div(slope, set(width[a]));
      hn::Store(inData, d, &hits.gradient[a][i]);
    }
    const Mask valid =
      hn::FirstN(d, hits.withNormals ? static_cast<std::size_t>(hits.count - i) : std::size_t(0));
    Vectors3 normal;
    for (int a = 0; a < 3; ++a)
    {
      normal[a] = hn::IfThenElse(valid, hn::Load(d, &hits.normal[a][i]), set(1.));
    }
    normal = normalizedVectors(normal);
    for (int a = 0; a < 3; ++a)
    {
      hn::Store(hn::IfThenElseZero(valid, normal[a]), d, &hits.normal[a][i]);
    }
  }
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeamr
{

HWY_EXPORT(FindNormals);

void findNormals(const Vec3& width, HitPlaces& hits) noexcept
{
  HWY_DYNAMIC_DISPATCH(FindNormals)(width, hits);
}

} // namespace treeamr
#endif
