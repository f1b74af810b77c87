#include "Surface/SurfaceFrame.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

using namespace treeamr;

TEST(SurfaceFrame, ShadesBySmoothNormalsOnTheSideThatIsSeen)
{
  const SurfaceFrame frame(
    Matrix4{ -2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 }); // stretches and mirrors
  const Vec3 eye{ 0., 0., 1. };
  const auto expectNear = [](const Vec3& n, const Vec3& expected) {
    EXPECT_NEAR(dot(n, normalized(expected)), 1., 1e-6) << n[0] << ' ' << n[1] << ' ' << n[2];
  };
  // Either side of the surface; normals transform by the inverse transpose.
  expectNear(frame.shadingNormal({ 0., 0., 3. }, { 0.6f, 0.f, 0.8f }, eye), { -0.3, 0., 0.8 });
  expectNear(frame.shadingNormal({ 0., 0., -3. }, { 0.6f, 0.f, -0.8f }, eye), { 0.3, 0., 0.8 });
  // Turned away from the eye where the piece is not: to the horizon and no further, never to the other side.
  expectNear(frame.shadingNormal({ 1., 0., 0.1 }, { 0.8f, 0.f, -0.6f }, eye), { -1., 0., 0. });
  expectNear(frame.shadingNormal({ -1., 0., -0.1 }, { -0.8f, 0.f, 0.6f }, eye), { -1., 0., 0. });
  // So does one that is turned away from the piece's own: it never changes sides abruptly.
  expectNear(frame.shadingNormal({ 0., 0., 1. }, { 0.8f, 0.f, -0.6f }, eye), { -1., 0., 0. });
  expectNear(frame.shadingNormal({ -1., 0., 0.1 }, { 0.8f, 0.f, 0.6f }, eye), { -0.4, 0., 0.6 });
  // No normal, and no gradient either.
  expectNear(frame.shadingNormal({ 0., 3., 4. }, {}, eye), { 0., 3., 4. });
  expectNear(frame.shadingNormal({}, {}, eye), eye);
}

TEST(SurfaceFrame, NormalizesVectorsOfAnyLength)
{
  for (const double length : { 5e-324, 1e-310, 1e-170, 1e-150, 1e-20, 1., 1e100, 1e155, 1e308 })
  {
    const Vec3 n = normalized({ -length, 0., length });
    EXPECT_DOUBLE_EQ(n[0], -std::sqrt(0.5)) << length;
    EXPECT_EQ(n[1], 0.) << length;
    EXPECT_DOUBLE_EQ(n[2], std::sqrt(0.5)) << length;
  }
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const Vec3& v : { Vec3{}, Vec3{ nan, 0., 1. }, Vec3{ 1e200, nan, 0. }, Vec3{ 1., -infinity, 0. } })
  {
    EXPECT_EQ(normalized(v), Vec3{});
  }
}
