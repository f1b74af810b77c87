// When a field has an offset, which one, and what is relative to it.
#include "Contour/Contour.h"
#include "Error.h"
#include "Field/Field.h"
#include "Interpolation/Sampler.h"
#include "Support/RandomTrees.h"
#include "Surface/Isosurface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

using namespace treeamr;
using namespace treeamr::test;

TEST(FieldOffset, IsThereWhereFloatLosesMoreThanA65536thOfTheRange)
{
  for (const double sign : { 1., -1. })
  {
    for (const double scale : { 1., 0x1p100, 0x1p-100 })
    {
      const auto offset = [&](double least, double greatest) {
        return sign > 0. ? offsetFor(scale * least, scale * greatest)
                         : offsetFor(-scale * greatest, -scale * least);
      };
      // Between 2 and 4 a step is 2^-22.
      EXPECT_EQ(offset(3., 3. + 0x1p-7), 0.);
      EXPECT_NE(offset(3., 3. + 0x1p-7 - 0x1p-50), 0.);
      EXPECT_EQ(offset(0., 1.), 0.);
      EXPECT_EQ(offset(-1., 3.), 0.);
    }
  }
  EXPECT_EQ(offsetFor(0., 0.), 0.);
  EXPECT_EQ(offsetFor(5., 5.), 5.);
  EXPECT_EQ(offsetFor(101325., 1e30), 0.) << "far out";
}

TEST(FieldOffset, IsARoundNumberAmidTheValues)
{
  EXPECT_EQ(offsetFor(101324.999, 101325.001), 101325.);
  EXPECT_EQ(offsetFor(1e6, 1e6 + 1e-3), 1e6 + 0x1p-10 * std::round(0.5e-3 / 0x1p-10));
  EXPECT_EQ(offsetFor(0x1p52 + 5., 0x1p52 + 12.), 0x1p52 + 8.);
  std::mt19937 engine(3);
  const auto uniform = [&] { return engine() / 4294967296.; };
  for (int i = 0; i < 10000; ++i)
  {
    const double middle = std::ldexp(uniform() - 0.5, static_cast<int>(200. * uniform()) - 100);
    const double least = middle * (1. + 1e-3 * uniform() * std::pow(10., -9. * uniform()));
    const double greatest = least + std::abs(middle) * 1e-3 * std::pow(10., -9. * uniform());
    const double offset = offsetFor(least, greatest);
    if (offset != 0.)
    {
      EXPECT_LE(std::abs(least - offset), greatest - least);
      EXPECT_LE(std::abs(greatest - offset), greatest - least);
      // Of floats it is found, too, at once or by and by.
      double found = 0.;
      for (int round = 0; round < 3; ++round)
      {
        found = offsetFor(static_cast<float>(least - found), static_cast<float>(greatest - found), found);
      }
      EXPECT_LE(std::abs(greatest - found), 2.001 * (greatest - least));
      EXPECT_EQ(
        offsetFor(static_cast<float>(least - found), static_cast<float>(greatest - found), found), found);
    }
  }
}

TEST(FieldOffset, IsOfWhatIsGivenAndSeen)
{
  auto built = buildOctree(RootGrid::uniform({ 2, 2, 2 }, { 0., 0., 0. }, { 1., 1., 1. }),
    makeRandomTree({ 5, { 2, 2, 2 }, 3, 0.6 }));
  const auto relative = std::make_shared<const Field>(built.octree, built.values);
  constexpr double offset = 0x1p40;
  const auto field = std::make_shared<const Field>(built.octree, built.values, offset);
  EXPECT_EQ(relative->offset(), 0.);
  EXPECT_EQ(field->offset(), offset);
  EXPECT_EQ(field->range().max, relative->range().max);
  TreePath path(*built.octree);
  forEachNode(path, [&](const TreePath& at) {
    if (!at.node().isNone())
    {
      EXPECT_EQ(field->relative(at.node()), relative->value(at.node()));
      EXPECT_EQ(field->value(at.node()), offset + relative->value(at.node()));
    }
  });
  for (const auto method : { InterpolationMethod::Nearest, InterpolationMethod::Current,
         InterpolationMethod::Finest, InterpolationMethod::Octant, InterpolationMethod::GTI })
  {
    const auto of = Sampler::create(method, field);
    const auto ofRelative = Sampler::create(method, relative);
    FieldSample sample;
    FieldSample expected;
    ASSERT_TRUE(of->sample({ 0.7, 1.1, 1.3 }, sample));
    ASSERT_TRUE(ofRelative->sample({ 0.7, 1.1, 1.3 }, expected));
    EXPECT_EQ(sample.value, offset + expected.value);
    EXPECT_EQ(sample.gradient, expected.gradient);
    ASSERT_TRUE(of->sampleRelative({ 0.7, 1.1, 1.3 }, sample));
    EXPECT_EQ(sample.value, expected.value);
    EXPECT_FALSE(of->sample({ 0.7, 2.1, 1.3 }, sample));
  }
  const ContourMesh mesh = contour(*field, offset + 0.25);
  EXPECT_FALSE(mesh.points.empty());
  EXPECT_EQ(mesh.points, contour(*relative, 0.25).points);
  EXPECT_EQ(interpolate(*field, mesh), interpolate(*relative, mesh));
  const Isosurface surface(field, { offset + 0.25, offset - 0.25, offset + 0.25 });
  EXPECT_EQ(surface.isovalues(), (std::vector<double>{ offset - 0.25, offset + 0.25 }));
  const Isosurface expected(relative, { 0.25, -0.25 });
  SurfaceHit hit;
  SurfaceHit expectedHit;
  const Ray ray{ { -1., 0.7, 0.9 }, { 1., 0.1, 0.05 } };
  ASSERT_TRUE(surface.intersect(ray, 0., 10., hit));
  ASSERT_TRUE(expected.intersect(ray, 0., 10., expectedHit));
  EXPECT_EQ(hit.t, expectedHit.t);
  EXPECT_EQ(hit.surface, expectedHit.surface);
  EXPECT_THROW(Field(built.octree, built.values, std::numeric_limits<double>::infinity()), Error);
}
