// Real 2-D forests made and saved by libp4est. libp4est is GPL: nothing outside Testing may use this.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace treeamr::test
{

class PlanarForest
{
public:
  using Point = std::array<double, 3>;
  struct Quadrant
  {
    int tree;
    int level;
    std::array<Point, 2> corners; // opposite ones, as libp4est maps them into the space of the vertices
    double value;                 // another one for each, 8 bytes of payload
  };

  static PlanarForest brick(int x, int y);
  /// Any of p4est_connectivity_new_byname: "rotwrap", "moebius", "star" ...
  static PlanarForest named(const std::string& name);

  /// Calls move(tree, corner, point) for each corner of each tree, which have vertices of their own after that.
  void moveCorners(const std::function<Point(int, int, const Point&)>& move);
  /// Leaves the topology alone, as deal.II does; quadrants() must not be asked after that.
  void dropVertices();
  /// One quadrant in `oneIn` of each level below the last.
  void refineAtRandom(int maxLevel, int oneIn);

  /// Tree by tree in Morton order.
  std::vector<Quadrant> quadrants() const;
  void save(const std::string& path, bool withPayload = true) const;

private:
  struct Impl;
  explicit PlanarForest(std::shared_ptr<Impl> impl);
  std::shared_ptr<Impl> impl_;
};

} // namespace treeamr::test
