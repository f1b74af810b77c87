// The roots of many cubics: visitRoots() and closeBracket() for vectors of them.
#include "InstructionSets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Surface/Kernel/FindRoots.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h: the rest is compiled once for each target.
#include "Surface/Kernel/SurfaceKernel.h"
#include "Surface/Kernel/SurfaceVectors-inl.h"

#include <bit>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

/// A vector of cubics.
struct Cubics
{
  std::array<Doubles, 4> c;

  HWY_INLINE Doubles at(Doubles s) const
  {
    return hn::Add(hn::Mul(hn::Add(hn::Mul(hn::Add(hn::Mul(c[3], s), c[2]), s), c[1]), s), c[0]);
  }
  HWY_INLINE Doubles slopeAt(Doubles s) const
  {
    return hn::Add(hn::Mul(hn::Add(hn::Mul(hn::Mul(set(3.), c[3]), s), hn::Mul(set(2.), c[2])), s), c[1]);
  }

  /// closeBracket() for some of them.
  HWY_INLINE Doubles closeBrackets(Mask open, Doubles a, Doubles b, Doubles atA, Doubles atB) const
  {
    const Tag d;
    const auto between = [&](Doubles s) { return hn::And(hn::Gt(s, a), hn::Lt(s, b)); };
    const auto middle = [&] { return hn::Mul(set(0.5), hn::Add(a, b)); };
    const Mask negativeAtA = hn::Lt(atA, hn::Zero(d));
    Doubles s = hn::Add(a, hn::Mul(hn::Sub(b, a), hn::Div(atA, hn::Sub(atA, atB))));
    s = hn::IfThenElse(between(s), s, middle());
    for (int i = 0; i < 64 && !hn::AllFalse(d, open); ++i)
    {
      const Doubles f = at(s);
      open = hn::AndNot(hn::Eq(f, hn::Zero(d)), open);
      const Mask isA = hn::Not(hn::Xor(hn::Lt(f, hn::Zero(d)), negativeAtA));
      a = hn::IfThenElse(hn::And(open, isA), s, a);
      b = hn::IfThenElse(hn::AndNot(isA, open), s, b);
      Doubles next = hn::Sub(s, hn::Div(f, slopeAt(s)));
      next = hn::IfThenElse(between(next), next, middle());
      const Mask isLast = hn::Or(hn::Eq(next, s), hn::Not(between(next)));
      s = hn::IfThenElse(open, next, s);
      open = hn::AndNot(isLast, open);
    }
    return s;
  }
};

/// The monotone pieces of [0, 1], ends of which are the extrema; missing ones are at the end.
struct Pieces
{
  static constexpr int most = 3;
  std::array<Doubles, most + 1> knots;
  std::array<Mask, most> isLast;

  HWY_INLINE explicit Pieces(const Cubics& cubics)
  {
    const Tag d;
    const auto& c = cubics.c;
    const Doubles zero = hn::Zero(d);
    const Doubles one = set(1.);
    // Roots of 3 c3 s^2 + 2 c2 s + c1, by the form without cancellation.
    const Doubles three = hn::Mul(set(3.), c[3]);
    const Doubles discriminant = hn::Sub(hn::Mul(c[2], c[2]), hn::Mul(three, c[1]));
    const Mask bends = hn::Gt(discriminant, zero);
    const Doubles root = hn::Sqrt(hn::IfThenElseZero(bends, discriminant));
    const Doubles q = hn::Neg(hn::Add(c[2], hn::CopySign(root, c[2])));
    const Doubles e0 = hn::Div(q, three);
    const Doubles e1 = hn::Div(c[1], q);
    const Mask ascends = hn::Lt(e0, e1);
    const Doubles lower = hn::IfThenElse(ascends, e0, e1);
    const Doubles upper = hn::IfThenElse(ascends, e1, e0);
    const auto inside = [&](Doubles e) { return hn::And(bends, hn::And(hn::Gt(e, zero), hn::Lt(e, one))); };
    const Mask hasLower = inside(lower);
    const Mask hasUpper = inside(upper);
    const Mask hasBoth = hn::And(hasLower, hasUpper);
    knots = { zero, hn::IfThenElse(hasLower, lower, hn::IfThenElse(hasUpper, upper, one)),
      hn::IfThenElse(hasBoth, upper, one), one };
    isLast = { hn::Not(hn::Or(hasLower, hasUpper)), hn::Not(hasBoth), hn::Eq(one, one) };
  }
};

void FindRoots(const OctantCandidates& candidates, bool firstOnly, CandidateRoots& found)
{
  const Tag d;
  const Doubles zero = hn::Zero(d);
  const Doubles one = set(1.);
  found.count = 0;
  for (int i = 0; i < candidates.count; i += lanes)
  {
    Cubics cubics;
    auto& c = cubics.c;
    for (int k = 0; k < 4; ++k)
    {
      c[k] = hn::LoadU(d, &candidates.cubic[k][i]);
    }
    const Doubles tolerance = hn::LoadU(d, &candidates.tolerance[i]);
    const auto snapped = [&](Doubles value) {
      return hn::IfThenZeroElse(hn::Le(hn::Abs(value), tolerance), value);
    };
    const Doubles first = snapped(c[0]);
    const Doubles last = snapped(cubics.at(one));
    const Doubles second = hn::Add(c[0], hn::Mul(c[1], set(1. / 3.)));
    const Doubles third = hn::Add(c[0], hn::Mul(hn::Add(hn::Mul(set(2.), c[1]), c[2]), set(1. / 3.)));
    const Doubles low = hn::Min(hn::Min(first, second), hn::Min(third, last));
    const Doubles high = hn::Max(hn::Max(first, second), hn::Max(third, last));
    Mask open = hn::AndNot(hn::Or(hn::Gt(low, tolerance), hn::Lt(high, hn::Neg(tolerance))),
      hn::FirstN(d, static_cast<std::size_t>(candidates.count - i)));

    const Pieces pieces(cubics);
    const Doubles t0 = hn::LoadU(d, &candidates.t0[i]);
    const Doubles length = hn::Sub(hn::LoadU(d, &candidates.t1[i]), t0);
    constexpr int most = CandidateRoots::mostOfEach;
    HWY_ALIGN double s[most][lanes];
    HWY_ALIGN double t[most][lanes];
    std::array<std::uint64_t, most> isRoot{};
    const auto add = [&](int slot, Mask roots, Doubles at) {
      hn::Store(at, d, s[slot]);
      hn::Store(hn::Add(t0, hn::Mul(at, length)), d, t[slot]);
      HWY_ALIGN std::uint8_t bits[8] = {};
      hn::StoreMaskBits(d, roots, bits);
      isRoot[slot] = bits[0];
      if (firstOnly)
      {
        open = hn::AndNot(roots, open);
      }
    };
    add(0, hn::And(open, hn::Eq(first, zero)), zero);
    Doubles before = first;
    for (int piece = 0; piece < Pieces::most && !hn::AllFalse(d, open); ++piece)
    {
      const Doubles after = hn::IfThenElse(pieces.isLast[piece], last, cubics.at(pieces.knots[piece + 1]));
      const Mask differs = hn::Xor(hn::Lt(before, zero), hn::Lt(after, zero));
      const Mask bracket =
        hn::And(hn::And(open, differs), hn::And(hn::Ne(before, zero), hn::Ne(after, zero)));
      Doubles root = pieces.knots[piece + 1];
      if (!hn::AllFalse(d, bracket))
      {
        root = hn::IfThenElse(bracket,
          cubics.closeBrackets(bracket, pieces.knots[piece], pieces.knots[piece + 1], before, after), root);
      }
      add(piece + 1, hn::Or(bracket, hn::And(open, hn::Eq(after, zero))), root);
      open = hn::AndNot(pieces.isLast[piece], open);
      before = after;
    }
    std::uint64_t any = 0;
    for (const std::uint64_t bits : isRoot)
    {
      any |= bits;
    }
    for (; any != 0; any &= any - 1)
    {
      const int lane = std::countr_zero(any);
      for (int slot = 0; slot < most; ++slot)
      {
        if (isRoot[slot] >> lane & 1)
        {
          found.s[found.count] = s[slot][lane];
          found.t[found.count] = t[slot][lane];
          found.candidate[found.count++] = i + lane;
        }
      }
    }
  }
}

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeamr
{

HWY_EXPORT(FindRoots);

void findRoots(const OctantCandidates& candidates, bool firstOnly, CandidateRoots& found) noexcept
{
  HWY_DYNAMIC_DISPATCH(FindRoots)(candidates, firstOnly, found);
}

} // namespace treeamr
#endif
