// The vectorised light of hits, against SurfaceFrame's normals and shade() on every instruction set: equal to the bit.
#include "Support/Targets.h"
#include "Surface/Kernel/SurfaceKernel.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

class Random
{
public:
  double operator()(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  Vec3 unit() { return normalized({ (*this)(-1., 1.), (*this)(-1., 1.), (*this)(-1., 1.) }); }

private:
  std::mt19937 random_{ 5 };
};

struct Hit
{
  Vec3 gradient;
  std::array<float, 3> normal;
  Material material;
};

/// Turned to the eye, away from it and across, vanishing, and of lengths whose squares are no numbers.
/// Some at a right angle to the line of sight, but for rounding.
Hit randomHit(Random& random, int kind, const Vec3& toEye)
{
  Hit hit{ random.unit(), {}, {} };
  const double length = kind % 7 == 1 ? 0. : kind % 7 == 2 ? 1e-200 : kind % 7 == 3 ? 1e200 : random(0.1, 5.);
  // A gradient along an axis is that of many flat fields.
  hit.gradient = kind % 5 == 0 ? Vec3{ 0., 0., length } : hit.gradient;
  if (kind % 17 == 5)
  {
    hit.gradient = normalized(cross(toEye, hit.gradient));
  }
  const Vec3 apart = random.unit();
  for (int a = 0; a < 3; ++a)
  {
    hit.normal[a] =
      kind % 7 == 1 ? 0.f : static_cast<float>(hit.gradient[a] + (kind % 3 == 0 ? 1.8 : 0.9) * apart[a]);
    hit.gradient[a] *= length;
    hit.material.ambient[a] = static_cast<float>(random(0., 0.4));
    hit.material.diffuse[a] = static_cast<float>(random(0., 1.));
  }
  if (kind % 13 == 4) // for an eye along z the normal is the line of sight
  {
    hit.gradient = { 1., 0., 0. };
    hit.normal = { 0.f, 0.f, -1.f };
  }
  return hit;
}

} // namespace

TEST(LightHits, IsWhatShadeFindsToTheBit)
{
  Random random;
  int across = 0; // normals that turn away from the eye
  forEachTarget([&](const char* target) {
    for (const Matrix4& matrix : { Matrix4{ 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 },
           Matrix4{ 0.3, -2., 0.1, 4., 0.7, 0.2, 0.9, 0., -0.4, 0.1, -1.5, 1., 0, 0, 0, 1 },
           Matrix4{ -1., 0, 0, 0, 0, 3., 0, 0, 0, 0, 1e-3, 0, 0, 0, 0, 1 } })
    {
      const SurfaceFrame frame(matrix);
      for (int i = 0; i < 3000; ++i)
      {
        std::vector<Light> lights(i % 4);
        for (Light& light : lights)
        {
          light.direction = random.unit();
          light.color = { static_cast<float>(random(0., 1.)), 0.5f, static_cast<float>(random(0., 1.)) };
        }
        const bool flat = i % 3 == 0;
        std::vector<Hit> expected;
        std::vector<Vec3> toEyes;
        HitsToLight hits;
        while (hits.count < 1 + i % HitsToLight::most)
        {
          toEyes.push_back((i + hits.count) % 11 == 0 ? Vec3{ 0., 0., 1. } : random.unit());
          const Hit hit = randomHit(random, i + hits.count, toEyes.back());
          hits.add(toEyes.back(), { 0., hit.gradient, hit.normal, 0, 0, 0 }, hit.material.ambient,
            hit.material.diffuse);
          expected.push_back(hit);
        }
        lightHits(frame, lights, flat, hits);
        for (int k = 0; k < hits.count; ++k)
        {
          const auto& [gradient, smooth, material] = expected[k];
          const Vec3& toEye = toEyes[k];
          const Vec3 normal =
            flat ? frame.worldNormal(gradient, toEye) : frame.shadingNormal(gradient, smooth, toEye);
          across += !flat && std::abs(dot(normal, toEye)) < 1e-12;
          const std::array<float, 3> rgb = shade(material, lights, {}, normal, {});
          for (int c = 0; c < 3; ++c)
          {
            ASSERT_EQ(std::bit_cast<std::uint32_t>(hits.rgb[c][k]), std::bit_cast<std::uint32_t>(rgb[c]))
              << hits.rgb[c][k] << " for " << rgb[c] << ", hit " << k << " of " << i << " on " << target;
          }
        }
      }
    }
  });
  EXPECT_GT(across, 1000);
}
