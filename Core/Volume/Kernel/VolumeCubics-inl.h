// The field on a ray's way through an octant of the vertices' lattice: a cubic, known from four places. Compiled once for
// each instruction set, as Highway wants it.
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

  /// What it does not exceed between its ends where these are less: the larger one of its inner Bernstein coefficients.
  HWY_INLINE Reals<Real> mostInside(Reals<Real> end) const
  {
    const Reals<Real> halfCubic = times(Real(0.5), cubic);
    const Reals<Real> slopeAtBegin = hn::Add(slope, halfCubic);
    const Reals<Real> slopeAtEnd = hn::Add(mulAdd(hn::Set(RealTag<Real>(), Real(2)), bend, slope), halfCubic);
    return hn::Max(
      hn::Add(begin, times(Real(1) / 3, slopeAtBegin)), hn::Sub(end, times(Real(1) / 3, slopeAtEnd)));
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

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif
