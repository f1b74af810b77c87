// Views of a domain of 2 x 2 x 2, and a transfer function for fields in [-1, 1].
#pragma once

#include "Field/TransferFunction.h"
#include "Support/Cameras.h"

#include <algorithm>
#include <vector>

namespace treeamr::test
{

/// Smooth, and fine enough that reading the nearest entry is as good as interpolating.
inline TransferFunction smooth()
{
  std::vector<TransferFunction::Entry> entries;
  for (int i = 0; i <= 1 << 16; ++i)
  {
    const float u = static_cast<float>(i) / (1 << 16);
    const float rise = std::max(0.f, u - 0.5f);
    entries.push_back({ u, 1.f - u, 0.5f, 30.f * rise * rise });
  }
  return TransferFunction(-1., 1., entries);
}

struct View
{
  const char* name;
  Matrix4 clip;
};

inline std::vector<View> views()
{
  const Vec3 middle{ 1., 1., 1. };
  return { { "perspective", multiply(perspective(40., 0.1, 20.), lookAt({ 4., 3., 3.5 }, middle)) },
    { "inside", multiply(perspective(90., 1e-3, 20.), lookAt({ 1.1, 0.8, 1.3 }, { 0., 0.1, 0.2 })) },
    { "narrow", multiply(perspective(0.3, 900., 1100.), lookAt({ 600., 500., 620. }, middle)) },
    { "parallel", multiply(parallel(1.9, 0.1, 20.), lookAt({ 4., 3., 3.5 }, middle)) },
    { "along an axis",
      multiply(parallel(1.2, 0.1, 20.), { 1, 0, 0, -1, 0, 1, 0, -1, 0, 0, 1, -5, 0, 0, 0, 1 }) } };
}

} // namespace treeamr::test
