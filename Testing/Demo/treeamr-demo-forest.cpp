// Writes the data of demo and benchmark: an example field on the unit cube as a forest of libp4est, one
// double per quadrant (the field at the cell's centre), balanced across faces, edges and corners.
//
// treeamr-demo-forest OUT.p8est [minLevel maxLevel threshold [mandelbulb | sheet]]
// By default 4 7 0.05 mandelbulb: 305,096 cells.
#include "ExampleFields.h"
#include "Support/ForestWriter.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <exception>
#include <iostream>
#include <string>
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

struct Refinement
{
  int minLevel = 4;
  int maxLevel = 7;
  double threshold = 0.05;
};

template <class Field>
void writeForest(const std::string& path, const Refinement& refinement, const Field& field)
{
  auto forest = treeamr::test::ForestWriter::unitCube();
  forest.refine([&](const ForestQuadrant& cell) {
    const double width = std::ldexp(1., -cell.level);
    return cell.level < refinement.minLevel ||
      (cell.level < refinement.maxLevel &&
        treeamr::rangeOverProbes(field,
          { cell.index[0] * width, cell.index[1] * width, cell.index[2] * width },
          width) > refinement.threshold);
  });
  forest.balance(treeamr::test::Balance::Full);
  forest.setPayload(sizeof(double), [&](const ForestQuadrant& cell, std::byte* payload) {
    const double width = std::ldexp(1., -cell.level);
    const double value =
      field((cell.index[0] + 0.5) * width, (cell.index[1] + 0.5) * width, (cell.index[2] + 0.5) * width);
    std::memcpy(payload, &value, sizeof(value));
  });
  forest.save(path);
  std::cout << forest.quadrantCount() << " cells\n";
}

} // namespace

int main(int argc, char* argv[])
{
  Refinement refinement;
  const std::string_view field = argc > 5 ? argv[5] : "mandelbulb";
  const bool understood = argc == 2 ||
    ((argc == 5 || argc == 6) && parse(argv[2], refinement.minLevel) && parse(argv[3], refinement.maxLevel) &&
      parse(argv[4], refinement.threshold));
  if (!understood || refinement.minLevel < 0 || refinement.maxLevel < refinement.minLevel ||
    refinement.maxLevel > treeamr::test::ForestWriter::maxLevel || std::isnan(refinement.threshold) ||
    (field != "mandelbulb" && field != "sheet"))
  {
    std::cerr << "usage: treeamr-demo-forest OUT.p8est [minLevel maxLevel threshold [mandelbulb | sheet]]\n"
              << "by default 4 7 0.05 mandelbulb; 0 <= minLevel <= maxLevel <= "
              << treeamr::test::ForestWriter::maxLevel << '\n';
    return 2;
  }
  try
  {
    if (field == "sheet")
    {
      writeForest(argv[1], refinement, treeamr::Sheet());
    }
    else
    {
      writeForest(argv[1], refinement, treeamr::mandelbulb);
    }
  }
  catch (const std::exception& error)
  {
    std::cerr << "treeamr-demo-forest: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
