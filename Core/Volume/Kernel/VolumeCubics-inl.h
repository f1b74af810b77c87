// The field on a ray's way through the octants of the vertices' lattice, in each of which it is a cubic: known from four
// places or from the derivatives in the middle. Compiled once for each instruction set, as Highway wants it.
#if defined(TREEAMR_VOLUMECUBICS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_VOLUMECUBICS_INL_H
#undef TREEAMR_VOLUMECUBICS_INL_H
#else
#define TREEAMR_VOLUMECUBICS_INL_H
#endif

#include "Volume/Kernel/VolumeSampling-inl.h"

#include <hwy/highway.h>

#include <limits>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

template <class Real>
HWY_INLINE Reals<Real> half()
{
  return hn::Set(RealTag<Real>(), Real(0.5));
}

/// Steps to the octants' faces, between which the field is smooth.
template <class Real>
class ToFaces
{
public:
  explicit HWY_INLINE ToFaces(const Span<Real>& span)
    : span_(span)
  {
    const RealTag<Real> d;
    for (int a = 0; a < 3; ++a)
    {
      // Of a ray along a face none is ahead.
      const Reals<Real> slope = hn::Mul(span.slope[a], span.step);
      slope_[a] = hn::CopySign(hn::Max(hn::Abs(slope), hn::Set(d, Real(1e-20))), slope);
      perSlope_[a] = hn::Div(hn::Set(d, Real(1)), slope_[a]);
    }
  }

  /// In samples; `at`: of the way.
  HWY_INLINE Reals<Real> operator()(Reals<Real> at) const
  {
    const RealTag<Real> d;
    Reals<Real> nearest = hn::Set(d, std::numeric_limits<Real>::max());
    for (int a = 0; a < 3; ++a)
    {
      const Reals<Real> position = mulAdd(at, slope_[a], span_.start[a]);
      // Not to the face that it is on.
      const Reals<Real> ahead = hn::Add(position, hn::CopySign(hn::Set(d, Real(0x1p-10)), slope_[a]));
      const Reals<Real> face =
        hn::IfThenElse(hn::Lt(slope_[a], hn::Zero(d)), hn::Floor(ahead), hn::Ceil(ahead));
      nearest = hn::Min(nearest, hn::Mul(hn::Sub(face, position), perSlope_[a]));
    }
    return nearest;
  }

private:
  const Span<Real>& span_;
  Reals<Real> slope_[3]; // of the lattice per sample
  Reals<Real> perSlope_[3];
};

/// The octants of a block that rays come to one after the other, in parts of a span (whose step is all of it).
template <class Real>
class OctantWalk
{
public:
  /// Each of three axes has four octants.
  static constexpr int most = 10;

  HWY_INLINE OctantWalk(const Span<Real>& span, const Lattice<Real>& lattice)
  {
    const RealTag<Real> d;
    constexpr Real strides[3] = { 1, 5, 25 };
    vertex_ = hn::Zero(d);
    for (int a = 0; a < 3; ++a)
    {
      // Of a ray along a face none is ahead.
      const Reals<Real> slope = hn::Mul(span.slope[a], span.step);
      const Reals<Real> unit = hn::CopySign(hn::Set(d, Real(1)), slope);
      const Reals<Real> inverse = hn::Div(unit, hn::Max(hn::Abs(slope), hn::Set(d, Real(1e-20))));
      const Mask<Real> rises = hn::Gt(unit, hn::Zero(d));
      const Reals<Real> first = hn::Set(d, lattice.first[a]);
      const Reals<Real> last = hn::Set(d, lattice.last[a]);
      // Beyond a face that it begins on.
      const Reals<Real> below = hn::IfThenElse(
        rises, hn::Floor(span.start[a]), hn::Sub(hn::Ceil(span.start[a]), hn::Set(d, Real(1))));
      const Reals<Real> cell = hn::Min(hn::Max(below, first), last);
      const auto placeOf = [&](Reals<Real> lower) {
        const Reals<Real> face = hn::Add(lower, hn::IfThenElseZero(rises, hn::Set(d, Real(1))));
        return hn::Mul(hn::Sub(face, span.start[a]), inverse);
      };
      perCell_[a] = hn::Abs(inverse);
      // Behind the last face but one there is no other.
      lastButOne_[a] = negMulAdd(perCell_[a], half<Real>(), placeOf(hn::IfThenElse(rises, last, first)));
      next_[a] = orNever(a, placeOf(cell));
      vertex_ = mulAdd(cell, hn::Set(d, strides[a]), vertex_);
      stride_[a] = hn::Mul(unit, hn::Set(d, strides[a]));
    }
  }

  /// The lowest one of the octant.
  HWY_INLINE Ints<Real> vertex() const { return truncated<Real>(vertex_); }
  HWY_INLINE Reals<Real> end() const { return hn::Min(hn::Min(next_[0], next_[1]), next_[2]); }

  HWY_INLINE void goOn()
  {
    const Reals<Real> left = end();
    for (int a = 0; a < 3; ++a)
    {
      const Mask<Real> crosses = hn::Le(next_[a], left);
      next_[a] = hn::IfThenElse(crosses, orNever(a, hn::Add(next_[a], perCell_[a])), next_[a]);
      vertex_ = hn::Add(vertex_, hn::IfThenElseZero(crosses, stride_[a]));
    }
  }

private:
  HWY_INLINE Reals<Real> orNever(int axis, Reals<Real> place) const
  {
    const Reals<Real> never = hn::Set(RealTag<Real>(), std::numeric_limits<Real>::max());
    return hn::IfThenElse(hn::Lt(place, lastButOne_[axis]), place, never);
  }

  Reals<Real> next_[3];
  Reals<Real> perCell_[3];
  Reals<Real> lastButOne_[3];
  Reals<Real> stride_[3]; // of vertices
  Reals<Real> vertex_;
};

/// begin + slope u + bend u^2 + cubic u (u - 1/2) (u - 1) for u from 0 to 1.
template <class Real>
struct CubicPiece
{
  Reals<Real> begin;
  Reals<Real> slope;
  Reals<Real> bend;
  Reals<Real> cubic;

  /// Through its values at the begin, a quarter of the way, the middle and the end.
  HWY_INLINE CubicPiece(Reals<Real> atBegin, Reals<Real> quarter, Reals<Real> middle, Reals<Real> end)
    : begin(atBegin)
  {
    const RealTag<Real> d;
    const Reals<Real> rise = hn::Sub(middle, begin);
    bend = times(2, hn::Sub(hn::Sub(end, middle), rise));
    slope = hn::Sub(times(2, rise), times(Real(0.5), bend));
    const Reals<Real> ofParabola =
      mulAdd(hn::Set(d, Real(0.25)), slope, mulAdd(hn::Set(d, Real(0.0625)), bend, begin));
    cubic = times(Real(64) / 3, hn::Sub(quarter, ofParabola));
  }

  HWY_INLINE Reals<Real> operator()(Reals<Real> u) const
  {
    const Reals<Real> one = hn::Set(RealTag<Real>(), Real(1));
    const Reals<Real> shape = hn::Mul(hn::Mul(u, hn::Sub(u, half<Real>())), hn::Sub(u, one));
    return mulAdd(cubic, shape, mulAdd(u, mulAdd(bend, u, slope), begin));
  }

  /// Where its derivative vanishes, inside or outside; NaN is no place.
  struct Turns
  {
    Reals<Real> at[2];
    Mask<Real> areReal;
  };
  HWY_INLINE Turns turns() const
  {
    const RealTag<Real> d;
    // Roots of the derivative, neither by a difference of near numbers.
    const Reals<Real> a = times(3, cubic);
    const Reals<Real> b = hn::Sub(times(2, bend), a);
    const Reals<Real> c = mulAdd(half<Real>(), cubic, slope);
    const Reals<Real> squared = hn::Sub(hn::Mul(b, b), times(4, hn::Mul(a, c)));
    const Reals<Real> sum =
      times(Real(-0.5), hn::Add(b, hn::CopySign(hn::Sqrt(hn::Max(squared, hn::Zero(d))), b)));
    return { { hn::Div(sum, a), hn::Div(c, sum) }, hn::Ge(squared, hn::Zero(d)) };
  }

private:
  static HWY_INLINE Reals<Real> times(Real factor, Reals<Real> v)
  {
    return hn::Mul(hn::Set(RealTag<Real>(), factor), v);
  }
};

/// constant + slope u + bend u^2 + cubic u^3 for u from -1 to 1, of places in a table.
template <class Real>
class CenteredCubic
{
public:
  /// Of what is between an octant's vertices on the way from f - way to f + way, in parts of its width.
  HWY_INLINE CenteredCubic(const Reals<Real> (&f)[3], const Reals<Real> (&way)[3],
    const Reals<Real> (&lower)[4], const Reals<Real> (&upper)[4], const ToTable<Real>& toTable)
  {
    const RealTag<Real> d;
    // Derivatives in the middle: first the rows along x, then the faces that they make, then these.
    Reals<Real> rise[4];
    Reals<Real> row[4];
    for (int r = 0; r < 4; ++r)
    {
      rise[r] = hn::Sub(upper[r], lower[r]);
      row[r] = mulAdd(f[0], rise[r], lower[r]);
    }
    Reals<Real> y[2];
    Reals<Real> x[2];
    Reals<Real> xy[2];
    Reals<Real> face[2];
    for (int z = 0; z < 2; ++z)
    {
      y[z] = hn::Sub(row[2 * z + 1], row[2 * z]);
      face[z] = mulAdd(f[1], y[z], row[2 * z]);
      xy[z] = hn::Sub(rise[2 * z + 1], rise[2 * z]);
      x[z] = mulAdd(f[1], xy[z], rise[2 * z]);
    }
    const Reals<Real> z = hn::Sub(face[1], face[0]);
    const Reals<Real> xz = hn::Sub(x[1], x[0]);
    const Reals<Real> yz = hn::Sub(y[1], y[0]);
    const Reals<Real> xyz = hn::Sub(xy[1], xy[0]);
    const Reals<Real> wayYZ = hn::Mul(way[1], way[2]);
    const Reals<Real> scale = hn::Set(d, toTable.scale);
    const Reals<Real> inMiddle = mulAdd(f[2], z, face[0]);
    constant_ = mulAdd(inMiddle, scale, hn::Set(d, toTable.offset));
    slope_ = hn::Mul(scale,
      mulAdd(way[0], mulAdd(f[2], xz, x[0]), mulAdd(way[1], mulAdd(f[2], yz, y[0]), hn::Mul(way[2], z))));
    bend_ = hn::Mul(scale,
      mulAdd(way[0], mulAdd(way[1], mulAdd(f[2], xyz, xy[0]), hn::Mul(way[2], xz)), hn::Mul(wayYZ, yz)));
    cubic_ = hn::Mul(hn::Mul(scale, way[0]), hn::Mul(wayYZ, xyz));
  }

  HWY_INLINE Reals<Real> begin() const { return hn::Sub(hn::Add(constant_, bend_), hn::Add(slope_, cubic_)); }
  HWY_INLINE Reals<Real> end() const { return hn::Add(hn::Add(constant_, bend_), hn::Add(slope_, cubic_)); }

  /// What it does not exceed between its ends where these are less: the larger one of its inner Bernstein coefficients.
  HWY_INLINE Reals<Real> mostInside() const
  {
    const Reals<Real> third = hn::Set(RealTag<Real>(), Real(1) / 3);
    const Reals<Real> even = negMulAdd(third, bend_, constant_);
    const Reals<Real> odd = negMulAdd(third, slope_, cubic_);
    return hn::Add(even, hn::Abs(odd));
  }

  /// Of some lanes the largest value where its derivative vanishes, unless that is less than `most`.
  HWY_INLINE Reals<Real> largestTurn(Mask<Real> lanes, Reals<Real> most) const
  {
    const RealTag<Real> d;
    const Reals<Real> one = hn::Set(d, Real(1));
    // Roots of the derivative, neither by a difference of near numbers.
    const Reals<Real> a = hn::Mul(hn::Set(d, Real(3)), cubic_);
    const Reals<Real> squared = hn::Sub(hn::Mul(bend_, bend_), hn::Mul(a, slope_));
    const Mask<Real> areReal = hn::And(lanes, hn::Ge(squared, hn::Zero(d)));
    const Reals<Real> sum =
      hn::Neg(hn::Add(bend_, hn::CopySign(hn::Sqrt(hn::Max(squared, hn::Zero(d))), bend_)));
    for (const Reals<Real> u : { hn::Div(sum, a), hn::Div(slope_, sum) })
    {
      const Mask<Real> isInside = hn::And(areReal, hn::Lt(hn::Abs(u), one)); // NaN is no place
      const Reals<Real> at = hn::IfThenElseZero(isInside, u);
      const Reals<Real> value = mulAdd(at, mulAdd(at, mulAdd(at, cubic_, bend_), slope_), constant_);
      most = hn::IfThenElse(isInside, hn::Max(most, value), most);
    }
    return most;
  }

private:
  Reals<Real> constant_;
  Reals<Real> slope_;
  Reals<Real> bend_;
  Reals<Real> cubic_;
};

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif
