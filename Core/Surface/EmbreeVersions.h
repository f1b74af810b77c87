// Rays through scenes of Embree 3 and 4, whose contexts and flags are handed over differently. TREEAMR_EMBREE is the version
// that CMake has found; nothing else depends on it.
#pragma once

#if TREEAMR_EMBREE >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace treeamr::embree
{

#if TREEAMR_EMBREE >= 4

using Context = RTCRayQueryContext;

inline void initialise(Context& context) noexcept
{
  rtcInitRayQueryContext(&context);
}

inline void intersect(RTCScene scene, Context& context, RTCRayHit& ray)
{
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context;
  rtcIntersect1(scene, &ray, &arguments);
}

/// 16 coherent rays.
inline void intersect(RTCScene scene, Context& context, const int* valid, RTCRayHit16& rays)
{
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context;
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect16(valid, scene, &rays, &arguments);
}

inline void occluded(RTCScene scene, Context& context, RTCRay& ray)
{
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = &context;
  rtcOccluded1(scene, &ray, &arguments);
}

#else

using Context = RTCIntersectContext;

inline void initialise(Context& context) noexcept
{
  rtcInitIntersectContext(&context);
}

inline void intersect(RTCScene scene, Context& context, RTCRayHit& ray)
{
  rtcIntersect1(scene, &context, &ray);
}

/// 16 coherent rays.
inline void intersect(RTCScene scene, Context& context, const int* valid, RTCRayHit16& rays)
{
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect16(valid, scene, &context, &rays);
}

inline void occluded(RTCScene scene, Context& context, RTCRay& ray)
{
  rtcOccluded1(scene, &context, &ray);
}

#endif

} // namespace treeamr::embree
