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
};

/// Brackets of roots of a vector of cubics, each in a monotone piece.
struct Brackets
{
  Doubles a;
  Doubles b;
  Doubles atA;
  Doubles atB;
  Mask open;
  Mask negativeAtA;
  Doubles s; // the roots, in the end

  HWY_INLINE Mask isBetween(Doubles x) const { return hn::And(hn::Gt(x, a), hn::Lt(x, b)); }
  HWY_INLINE Doubles middle() const { return hn::Mul(set(0.5), hn::Add(a, b)); }

  HWY_INLINE void start()
  {
    negativeAtA = hn::Lt(atA, hn::Zero(Tag()));
    s = hn::Add(a, hn::Mul(hn::Sub(b, a), hn::Div(atA, hn::Sub(atA, atB))));
    s = hn::IfThenElse(isBetween(s), s, middle());
  }
  /// A step of closeBracket().
  HWY_INLINE void step(const Cubics& cubics)
  {
    const Tag d;
    const Doubles f = cubics.at(s);
    open = hn::AndNot(hn::Eq(f, hn::Zero(d)), open);
    const Mask isA = hn::Not(hn::Xor(hn::Lt(f, hn::Zero(d)), negativeAtA));
    a = hn::IfThenElse(hn::And(open, isA), s, a);
    b = hn::IfThenElse(hn::AndNot(isA, open), s, b);
    const Doubles slope = cubics.slopeAt(s);
    const Doubles newton = hn::Sub(s, hn::Div(f, slope));
    const Mask isNewton = isBetween(newton);
    const Doubles next = hn::IfThenElse(isNewton, newton, middle());
    const Doubles change = hn::Sub(next, s);
    const Doubles bend = hn::Abs(hn::Add(hn::Mul(hn::Mul(set(3.), cubics.c[3]), s), cubics.c[2]));
    const Doubles steep = hn::Abs(slope);
    const Mask isExact =
      hn::And(hn::Le(hn::Mul(hn::Mul(change, change), bend), hn::Mul(set(negligibleError), steep)),
        hn::Gt(steep, set(leastSlope)));
    const Mask isLast = hn::Or(hn::And(isNewton, isExact), hn::Or(hn::Eq(next, s), hn::Not(isBetween(next))));
    s = hn::IfThenElse(open, next, s);
    open = hn::AndNot(isLast, open);
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

/// A vector of candidates and their roots.
struct RootSearch
{
  static constexpr int most = CandidateRoots::mostOfEach;
  Cubics cubics;
  std::array<Doubles, Pieces::most + 1> knots;
  std::array<Doubles, Pieces::most + 1> values;
  std::array<Mask, Pieces::most> isBracket; // whose roots are not known yet
  Brackets brackets;
  std::array<Doubles, most> s;
  std::array<Mask, most> isRoot;

  HWY_INLINE void start(const OctantCandidates& candidates, int i, bool firstOnly)
  {
    const Tag d;
    const Doubles zero = hn::Zero(d);
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
    const Doubles last = snapped(cubics.at(set(1.)));
    const Doubles second = hn::Add(c[0], hn::Mul(c[1], set(1. / 3.)));
    const Doubles third = hn::Add(c[0], hn::Mul(hn::Add(hn::Mul(set(2.), c[1]), c[2]), set(1. / 3.)));
    const Doubles low = hn::Min(hn::Min(first, second), hn::Min(third, last));
    const Doubles high = hn::Max(hn::Max(first, second), hn::Max(third, last));
    const std::size_t rest = i < candidates.count ? static_cast<std::size_t>(candidates.count - i) : 0;
    Mask open =
      hn::AndNot(hn::Or(hn::Gt(low, tolerance), hn::Lt(high, hn::Neg(tolerance))), hn::FirstN(d, rest));

    const Pieces pieces(cubics);
    knots = pieces.knots;
    values[0] = first;
    s[0] = zero;
    isRoot[0] = hn::And(open, hn::Eq(first, zero));
    const auto found = [&](Mask roots) { open = firstOnly ? hn::AndNot(roots, open) : open; };
    found(isRoot[0]);
    for (int piece = 0; piece < Pieces::most; ++piece)
    {
      const Doubles before = values[piece];
      const Doubles after = hn::IfThenElse(pieces.isLast[piece], last, cubics.at(knots[piece + 1]));
      const Mask differs = hn::Xor(hn::Lt(before, zero), hn::Lt(after, zero));
      isBracket[piece] = hn::And(hn::And(open, differs), hn::And(hn::Ne(before, zero), hn::Ne(after, zero)));
      s[piece + 1] = knots[piece + 1];
      isRoot[piece + 1] = hn::Or(isBracket[piece], hn::And(open, hn::Eq(after, zero)));
      found(isRoot[piece + 1]);
      open = hn::AndNot(pieces.isLast[piece], open);
      values[piece + 1] = after;
    }
  }

  /// Takes the next bracket of each cubic; false: there is none left.
  HWY_INLINE bool nextBrackets(std::array<Mask, Pieces::most>& taken)
  {
    const Tag d;
    const Doubles zero = hn::Zero(d);
    brackets.open = hn::Ne(zero, zero);
    brackets.a = brackets.atA = zero;
    brackets.b = brackets.atB = set(1.);
    for (int piece = 0; piece < Pieces::most; ++piece)
    {
      const Mask takes = taken[piece] = hn::AndNot(brackets.open, isBracket[piece]);
      brackets.a = hn::IfThenElse(takes, knots[piece], brackets.a);
      brackets.b = hn::IfThenElse(takes, knots[piece + 1], brackets.b);
      brackets.atA = hn::IfThenElse(takes, values[piece], brackets.atA);
      brackets.atB = hn::IfThenElse(takes, values[piece + 1], brackets.atB);
      brackets.open = hn::Or(brackets.open, takes);
      isBracket[piece] = hn::AndNot(takes, isBracket[piece]);
    }
    brackets.start();
    return !hn::AllFalse(d, brackets.open);
  }
  HWY_INLINE void takeRoots(const std::array<Mask, Pieces::most>& taken)
  {
    for (int piece = 0; piece < Pieces::most; ++piece)
    {
      s[piece + 1] = hn::IfThenElse(taken[piece], brackets.s, s[piece + 1]);
    }
  }

  /// In the order of the candidates, from the i-th on.
  HWY_INLINE void store(const OctantCandidates& candidates, int i, CandidateRoots& found) const
  {
    const Tag d;
    const Doubles t0 = hn::LoadU(d, &candidates.t0[i]);
    const Doubles length = hn::Sub(hn::LoadU(d, &candidates.t1[i]), t0);
    HWY_ALIGN double ofS[most][lanes];
    HWY_ALIGN double ofT[most][lanes];
    std::array<std::uint32_t, most> bits{};
    std::uint32_t any = 0;
    for (int slot = 0; slot < most; ++slot)
    {
      hn::Store(s[slot], d, ofS[slot]);
      hn::Store(hn::Add(t0, hn::Mul(s[slot], length)), d, ofT[slot]);
      HWY_ALIGN std::uint8_t byte[8] = {};
      hn::StoreMaskBits(d, isRoot[slot], byte);
      bits[slot] = byte[0];
      any |= bits[slot];
    }
    for (; any != 0; any &= any - 1)
    {
      const int lane = std::countr_zero(any);
      for (int slot = 0; slot < most; ++slot)
      {
        if (bits[slot] >> lane & 1)
        {
          found.s[found.count] = ofS[slot][lane];
          found.t[found.count] = ofT[slot][lane];
          found.candidate[found.count++] = i + lane;
        }
      }
    }
  }
};

void FindRoots(const OctantCandidates& candidates, bool firstOnly, CandidateRoots& found)
{
  const Tag d;
  found.count = 0;
  // Two vectors side by side: each step of a search waits for the one before.
  for (int i = 0; i < candidates.count; i += 2 * lanes)
  {
    RootSearch low;
    RootSearch high;
    low.start(candidates, i, firstOnly);
    high.start(candidates, i + lanes, firstOnly);
    std::array<Mask, Pieces::most> ofLow;
    std::array<Mask, Pieces::most> ofHigh;
    // Hardly ever more than once.
    for (;;)
    {
      const bool any = low.nextBrackets(ofLow);
      if (!high.nextBrackets(ofHigh) && !any)
      {
        break;
      }
      for (int step = 0; step < mostSteps && !hn::AllFalse(d, hn::Or(low.brackets.open, high.brackets.open));
           ++step)
      {
        low.brackets.step(low.cubics);
        high.brackets.step(high.cubics);
      }
      low.takeRoots(ofLow);
      high.takeRoots(ofHigh);
    }
    low.store(candidates, i, found);
    if (i + lanes < candidates.count)
    {
      high.store(candidates, i + lanes, found);
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
