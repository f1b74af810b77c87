// Writes the demo's data: the Mandelbulb on the unit cube as a forest of libp4est, one double per quadrant
// (the field at the cell's centre), balanced across faces, edges and corners.
//
// treeamr-demo-forest OUT.p8est [minLevel maxLevel threshold]   (4 7 0.05: 305,096 cells)
#include "ExampleFields.h"
#include "Support/ForestWriter.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <exception>
#include <iostream>
#include <string_view>

namespace
{

using treeamr::test::ForestQuadrant;

template <class Number>
bool parse(std::string_view text, Number& number)
{
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
  return code == std::errc() && end == text.data() + text.size();
}

} // namespace

int main(int argc, char* argv[])
{
  int minLevel = 4;
  int maxLevel = 7;
  double threshold = 0.05;
  const bool understood = argc == 2 ||
    (argc == 5 && parse(argv[2], minLevel) && parse(argv[3], maxLevel) && parse(argv[4], threshold));
  if (!understood || minLevel < 0 || maxLevel < minLevel ||
    maxLevel > treeamr::test::ForestWriter::maxLevel || std::isnan(threshold))
  {
    std::cerr << "usage: treeamr-demo-forest OUT.p8est [minLevel maxLevel threshold]   (4 7 0.05)\n"
              << "0 <= minLevel <= maxLevel <= " << treeamr::test::ForestWriter::maxLevel << '\n';
    return 2;
  }
  try
  {
    auto forest = treeamr::test::ForestWriter::unitCube();
    forest.refine([&](const ForestQuadrant& cell) {
      const double width = std::ldexp(1., -cell.level);
      return cell.level < minLevel ||
        (cell.level < maxLevel &&
          treeamr::rangeOverProbes(treeamr::mandelbulb,
            { cell.index[0] * width, cell.index[1] * width, cell.index[2] * width }, width) > threshold);
    });
    forest.balance(treeamr::test::Balance::Full);
    forest.setPayload(sizeof(double), [](const ForestQuadrant& cell, std::byte* payload) {
      const double width = std::ldexp(1., -cell.level);
      const double value = treeamr::mandelbulb(
        (cell.index[0] + 0.5) * width, (cell.index[1] + 0.5) * width, (cell.index[2] + 0.5) * width);
      std::memcpy(payload, &value, sizeof(value));
    });
    forest.save(argv[1]);
    std::cout << forest.quadrantCount() << " cells\n";
  }
  catch (const std::exception& error)
  {
    std::cerr << "treeamr-demo-forest: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
