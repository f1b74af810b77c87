// Real 3-D forests made and saved by libp4est, for tests and the demo's data. libp4est is GPL: nothing
// outside Testing may use this.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace treeamr::test
{

/// A leaf as libp4est has it.
struct ForestQuadrant
{
  int tree = 0;
  std::array<std::uint32_t, 3> index{}; // in [0, 2^level), on the lattice of its level in the tree
  int level = 0;
  std::vector<std::byte> payload;
};

enum class Balance
{
  Face,
  Edge,
  Full
};

/// One process, serial. Each starts as one quadrant per tree, without a payload.
class ForestWriter
{
public:
  using Point = std::array<double, 3>;
  using Corners = std::array<Point, 8>;

  /// Deepest level of the libp4est this is built with.
  static const int maxLevel;

  static ForestWriter unitCube();
  static ForestWriter brick(std::array<int, 3> trees, std::array<bool, 3> periodic = {});
  /// Any of p8est_connectivity_new_byname: "rotcubes", "shell", "twowrap" ...
  static ForestWriter named(const std::string& name);
  /// Trees without neighbours, each by its corners in p4est's order (x fastest).
  static ForestWriter separateTrees(const std::vector<Corners>& trees);
  /// The same joined where they share four corners; all right-handed.
  static ForestWriter joinedTrees(const std::vector<Corners>& trees);
  /// Topology alone: one tree, no vertices.
  static ForestWriter withoutVertices();

  void moveVertices(const std::function<Point(const Point&)>& move);
  /// Leaves the topology alone, as deal.II does; bounds() must not be asked after that.
  void dropVertices();
  /// Bytes that p4est keeps for the user of the connectivity.
  void setTreeAttributes(std::size_t bytesPerTree);

  /// Recursively; the payload of the quadrant handed over is empty.
  void refine(const std::function<bool(const ForestQuadrant&)>& shouldRefine);
  void balance(Balance balance);
  /// fill writes `bytes` bytes per quadrant.
  void setPayload(std::size_t bytes, const std::function<void(const ForestQuadrant&, std::byte*)>& fill);

  /// Tree by tree in Morton order.
  std::vector<ForestQuadrant> quadrants() const;
  std::int64_t quadrantCount() const;
  /// The lower and upper corner, as libp4est maps them into the space of the vertices.
  std::array<Point, 2> bounds(const ForestQuadrant& quadrant) const;

  void save(const std::string& path, bool withPayload = true) const;
  /// As p8est_vtk does: prefix.pvtu and one piece, with treeid, level, mpirank and the values, one a quadrant, rounded to
  /// float. scale: of the cells about their centres, 0.95 unless told.
  void saveVtk(const std::string& prefix, const std::string& name, const std::vector<double>& values,
    double scale = 0.95) const;
  void saveConnectivity(const std::string& path) const;

private:
  struct Impl;
  explicit ForestWriter(std::shared_ptr<Impl> impl);
  std::shared_ptr<Impl> impl_;
};

} // namespace treeamr::test
