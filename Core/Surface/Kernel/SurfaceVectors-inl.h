// Vectors of rays, for the stages of the surface kernel. Compiled once for each instruction set, as Highway wants it.
#if defined(TREEAMR_SURFACEVECTORS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TREEAMR_SURFACEVECTORS_INL_H
#undef TREEAMR_SURFACEVECTORS_INL_H
#else
#define TREEAMR_SURFACEVECTORS_INL_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace treeamr
{
namespace HWY_NAMESPACE
{

namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<double, 8>;
using IntTag = hn::RebindToSigned<Tag>;
using BitsTag = hn::RebindToUnsigned<Tag>;
using Doubles = hn::Vec<Tag>;
using Integers = hn::Vec<IntTag>;
using Mask = hn::Mask<Tag>;

HWY_INLINE Doubles set(double x)
{
  return hn::Set(Tag(), x);
}

constexpr int lanes = hn::MaxLanes(Tag());

} // namespace HWY_NAMESPACE
} // namespace treeamr
HWY_AFTER_NAMESPACE();

#endif
