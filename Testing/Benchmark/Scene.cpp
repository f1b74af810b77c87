#include "Scene.h"

#include "Error.h"
#include "Forest/P4estForestFile.h"
#include "Support/Cameras.h"
#include "Support/ProceduralTree.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

namespace treeamr::bench
{

namespace
{

/// color(u) gives red, green and blue, extinction(u) is per edge length, both for u of [0, max].
template <class Color, class Extinction>
TransferFunction tabulate(float max, const Color& color, const Extinction& extinction)
{
  constexpr int size = 4096;
  std::vector<TransferFunction::Entry> entries;
  for (int i = 0; i < size; ++i)
  {
    const float u = max * static_cast<float>(i) / (size - 1);
    const auto [r, g, b] = color(u);
    entries.push_back({ r, g, b, extinction(u) });
  }
  return TransferFunction(0., max, std::move(entries));
}

TransferFunction mandelbulbTransferFunction()
{
  return tabulate(
    1.f,
    [](float u) {
      return std::array{ u, 1.f - u, 0.5f };
    },
    [](float u) {
      const float rise = std::max(0.f, u - 0.3f) / 0.6f;
      return 60.f * std::min(1.f, rise * rise);
    });
}

TransferFunction sheetTransferFunction()
{
  return tabulate(
    2.f,
    [](float u) {
      return std::array{ std::min(1.f, u), 0.9f - 0.4f * u, std::max(0.f, 1.f - u) };
    },
    [](float u) { return 30.f * std::clamp(1.2f * (u - 0.15f), 0.f, 1.f); });
}

std::shared_ptr<Field> makeField(OctreeAndValues built)
{
  auto field = std::make_shared<Field>(std::move(built.octree), std::move(built.values));
  field->nodeRanges();
  return field;
}

} // namespace

std::vector<Scene> makeScenes()
{
  return { { "mandelbulb-0.3M", mandelbulbTransferFunction(), 0.9, {} },
    { "mandelbulb-2.6M", mandelbulbTransferFunction(), 0.9, {} },
    { "mandelbulb-20M", mandelbulbTransferFunction(), 0.9, { 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5, 0.7 } },
    { "sheet-23M", sheetTransferFunction(), 0.5, {} } };
}

Camera makeCamera(int pixels)
{
  const double elevation = 25. * std::numbers::pi / 180.;
  const double azimuth = 35. * std::numbers::pi / 180.;
  const Vec3 eye{ 0.5 + 1.6 * std::cos(elevation) * std::sin(azimuth), 0.5 + 1.6 * std::sin(elevation),
    0.5 + 1.6 * std::cos(elevation) * std::cos(azimuth) };
  const Matrix4 view = test::lookAt(eye, { 0.5, 0.5, 0.5 }, { 0., 1., 0. });
  return Camera(test::multiply(test::perspective(40., 0.1, 10.), view), test::identityMatrix, pixels, pixels);
}

Forest readForest(const std::string& path)
{
  const P4estForestFile file(path);
  if (file.treeCount() != 1 || file.payloadSize() != sizeof(double))
  {
    throw Error(path + ": " + std::to_string(file.treeCount()) + " trees and " +
      std::to_string(file.payloadSize()) + " bytes per quadrant, allowed are 1 and 8");
  }
  Forest forest;
  forest.cells.reserve(file.quadrantCount());
  file.visitQuadrants([&](const TreeLeaf& q) {
    double value;
    std::memcpy(&value, q.payload, sizeof(value));
    forest.cells.push_back(
      { { { q.index[0], q.index[1], q.index[2] }, q.level }, static_cast<float>(value) });
    // In Morton order the levels say where the cells are.
    forest.digest.add(static_cast<std::uint64_t>(q.level));
    forest.digest.add(value);
  });
  return forest;
}

Forest makeSyntheticForest()
{
  Forest forest;
  forest.roots = { 4, 4, 4 };
  const auto add = [&](const CellId& cell) {
    double product = 1.;
    for (const Coord i : cell.index)
    {
      product *= std::ldexp(static_cast<double>(i) + 0.5, -cell.level);
    }
    forest.cells.push_back({ cell, static_cast<float>(product) });
  };
  for (Coord i = 0; i < 64; ++i)
  {
    const std::array<Coord, 3> root{ i % 4, i / 4 % 4, i / 16 };
    if (root[0] < 2)
    {
      add({ root, 0 });
      continue;
    }
    for (int o = 0; o < 8; ++o)
    {
      add({ { 2 * root[0] + (o & 1), 2 * root[1] + (o >> 1 & 1), 2 * root[2] + (o >> 2) }, 1 });
    }
  }
  return forest;
}

std::shared_ptr<Field> buildField(const std::array<int, 3>& roots, LargeVector<LeafCell> cells)
{
  return makeField(
    buildOctree(RootGrid::uniform(roots, { 0., 0., 0. }, { 1. / roots[0], 1. / roots[1], 1. / roots[2] }),
      std::move(cells)));
}

std::shared_ptr<Field> buildProceduralField(int deepest, double widths)
{
  return makeField(buildOctree(
    RootGrid::uniform({ 1, 1, 1 }, { 0., 0., 0. }, { 1., 1., 1. }), test::ProceduralTree(deepest, widths)));
}

} // namespace treeamr::bench
