// Writes the data of demo and benchmark: an example field on the unit cube as a forest of libp4est, one
// double per quadrant (the field at the cell's centre), balanced across faces, edges and corners.
//
// treeamr-demo-forest OUT.p8est [minLevel maxLevel threshold [mandelbulb | sheet | sphere [trees]]]
// By default 4 7 0.05 mandelbulb: 305,096 cells. Sphere: the Mandelbulb's cells with the distance from the centre.
// Levels count from the trees, of which there are 1 or more along each axis.
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

constexpr int maxTrees = 64; // along each axis

struct Refinement
{
  int minLevel = 4;
  int maxLevel = 7;
  double threshold = 0.05;
};

double distanceFromCentre(double x, double y, double z)
{
  return std::hypot(x - 0.5, y - 0.5, z - 0.5);
}

/// The cells of one field with the values of another (or the same).
template <class Cells, class Values>
void writeForest(
  const std::string& path, const Refinement& refinement, int trees, const Cells& cells, const Values& values)
{
  using treeamr::test::ForestWriter;
  auto forest = ForestWriter::brick({ trees, trees, trees });
  forest.moveVertices([&](const ForestWriter::Point& p) {
    return ForestWriter::Point{ p[0] / trees, p[1] / trees, p[2] / trees };
  });
  forest.refine([&](const ForestQuadrant& cell) {
    const auto [low, high] = forest.bounds(cell);
    return cell.level < refinement.minLevel ||
      (cell.level < refinement.maxLevel &&
        treeamr::rangeOverProbes(cells, low, high[0] - low[0]) > refinement.threshold);
  });
  forest.balance(treeamr::test::Balance::Full);
  forest.setPayload(sizeof(double), [&](const ForestQuadrant& cell, std::byte* payload) {
    const auto [low, high] = forest.bounds(cell);
    const double value = values(0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0.5 * (low[2] + high[2]));
    std::memcpy(payload, &value, sizeof(value));
  });
  forest.save(path);
  std::cout << forest.quadrantCount() << " cells\n";
}

} // namespace

int main(int argc, char* argv[])
{
  Refinement refinement;
  int trees = 1;
  const std::string_view field = argc > 5 ? argv[5] : "mandelbulb";
  const bool understood = argc == 2 ||
    (argc >= 5 && argc <= 7 && parse(argv[2], refinement.minLevel) && parse(argv[3], refinement.maxLevel) &&
      parse(argv[4], refinement.threshold) && (argc < 7 || parse(argv[6], trees)));
  if (!understood || refinement.minLevel < 0 || refinement.maxLevel < refinement.minLevel ||
    refinement.maxLevel > treeamr::test::ForestWriter::maxLevel || std::isnan(refinement.threshold) ||
    (field != "mandelbulb" && field != "sheet" && field != "sphere") || trees < 1 || trees > maxTrees)
  {
    std::cerr << "usage: treeamr-demo-forest OUT.p8est [minLevel maxLevel threshold [mandelbulb | sheet | "
                 "sphere [trees]]]\n"
              << "by default 4 7 0.05 mandelbulb 1; 0 <= minLevel <= maxLevel <= "
              << treeamr::test::ForestWriter::maxLevel << ", 1 <= trees <= " << maxTrees << '\n';
    return 2;
  }
  try
  {
    if (field == "sheet")
    {
      const treeamr::Sheet sheet;
      writeForest(argv[1], refinement, trees, sheet, sheet);
    }
    else if (field == "sphere")
    {
      writeForest(argv[1], refinement, trees, treeamr::mandelbulb, distanceFromCentre);
    }
    else
    {
      writeForest(argv[1], refinement, trees, treeamr::mandelbulb, treeamr::mandelbulb);
    }
  }
  catch (const std::exception& error)
  {
    std::cerr << "treeamr-demo-forest: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
