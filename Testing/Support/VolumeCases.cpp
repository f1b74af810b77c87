#include "Support/VolumeCases.h"

#include "ExampleFields.h"
#include "Support/Fields.h"
#include "Support/RandomTrees.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace treeamr::test
{

namespace
{

using Entry = TransferFunction::Entry;
using Node = TransferFunction::Node;

Entry entry(double color, double extinction)
{
  return { static_cast<float>(color), static_cast<float>(1. - color), 0.5f, static_cast<float>(extinction) };
}

TransferFunction lines(const std::vector<std::pair<double, double>>& extinctions)
{
  std::vector<Node> nodes;
  for (const auto& [value, extinction] : extinctions)
  {
    nodes.push_back({ value, entry(value, extinction), entry(value, extinction) });
  }
  return TransferFunction::ofNodes(nodes);
}

/// Of one optical depth per unit of value, so wide on each side.
TransferFunction spikes(int count, double halfWidth)
{
  std::vector<std::pair<double, double>> points{ { 0., 0. } };
  for (int i = 0; i < count; ++i)
  {
    const double at = (i + 0.37) / count;
    points.insert(points.end(), { { at - halfWidth, 0. }, { at, 0.3 / halfWidth }, { at + halfWidth, 0. } });
  }
  points.emplace_back(1., 0.);
  return lines(points);
}

/// ParaView's default: opacity over a tenth of a unit is the value, so all of it at the largest.
TransferFunction toOpacityOne()
{
  constexpr double unit = 0.1;
  std::vector<Node> nodes;
  for (int i = 0; i < 60; ++i)
  {
    const double passes = std::pow(0.75, i);
    const Entry e = entry(1. - passes, -std::log(passes) / unit);
    nodes.push_back({ 1. - passes, e, e });
  }
  nodes.push_back({ 1., entry(1., 19. / unit), entry(1., TransferFunction::opaqueExtinction) });
  return TransferFunction::ofNodes(nodes);
}

TransferFunction logarithmic()
{
  std::vector<Node> nodes;
  for (int i = 0; i <= 120; ++i)
  {
    const Entry e = entry(i / 120., 5. * i / 120.);
    nodes.push_back({ std::pow(10., -6. + i / 20.), e, e });
  }
  return TransferFunction::ofNodes(nodes);
}

TransferFunction noise()
{
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(0.f, 1.f);
  std::vector<Node> nodes;
  for (int i = 0; i < 1000; ++i)
  {
    const Entry e{ uniform(random), uniform(random), uniform(random), 6.f * uniform(random) };
    nodes.push_back({ i / 999., e, e });
  }
  return TransferFunction::ofNodes(nodes);
}

} // namespace

Named<std::function<double(const Point&)>> volumeFieldValues()
{
  return { { "line", [](const Point& p) { return (p[0] + 0.3 * p[1] + 0.2 * p[2]) / 3.; } },
    { "shock", [](const Point& p) { return p[0] + 0.31 * p[1] > 1.2 ? 1000. : 0.3 * p[2]; } },
    { "Gaussian",
      [](const Point& p) {
        return std::exp(-4. * (std::pow(p[0] - 1., 2) + std::pow(p[1] - 1., 2) + std::pow(p[2] - 1., 2)));
      } },
    { "Mandelbulb", [](const Point& p) { return mandelbulb(0.5 * p[0], 0.5 * p[1], 0.5 * p[2]); } },
    { "sheet",
      [sheet = Sheet()](const Point& p) { return 0.5 * sheet(0.5 * p[0], 0.5 * p[1], 0.5 * p[2]); } } };
}

Named<std::shared_ptr<const Field>> volumeFields()
{
  Named<std::shared_ptr<const Field>> fields;
  auto cells = makeRandomTree({ 12, { 2, 2, 2 }, 4, 0.6, 0., false });
  for (const auto& [name, value] : volumeFieldValues())
  {
    setValues(cells, value);
    fields.emplace_back(name, makeField(unitRoots({ 2, 2, 2 }), cells));
  }
  return fields;
}

Named<TransferFunction> volumeFunctions()
{
  constexpr double opaque = TransferFunction::opaqueExtinction;
  return { { "to opacity 1", toOpacityOne() }, { "ramp", lines({ { 0., 0. }, { 1., 20. } }) },
    { "logarithmic", logarithmic() },
    { "step", TransferFunction::ofNodes({ { 0.5, entry(0.2, 0.), entry(0.8, 8.) } }) },
    { "opaque", TransferFunction::ofNodes({ { 0.5, entry(0.2, 0.), entry(0.8, opaque) } }) },
    { "opaque, its colour changes",
      TransferFunction::ofNodes(
        { { 0.4, entry(0.4, 0.), entry(0., opaque) }, { 0.9, entry(1., opaque), entry(1., opaque) } }) },
    { "spike 1e-2", spikes(1, 1e-2) }, { "spike 1e-4", spikes(1, 1e-4) }, { "spike 1e-6", spikes(1, 1e-6) },
    { "thirty spikes", spikes(30, 1e-4) }, { "noise", noise() },
    { "faint", lines({ { 0., 0. }, { 1., 0.01 } }) } };
}

} // namespace treeamr::test
