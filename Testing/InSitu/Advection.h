// A small simulation on a forest of libp4est, spread over processes: a drop of dye in LeVeque's swirling flow (SIAM J. Numer.
// Anal. 33, 1996, eq. 9.8, without its turning back), by finite volumes of first order. The forest is refined where neighbours
// differ, coarsened where they do not, balanced across faces, edges and corners, and partitioned anew.
#pragma once

#include <p8est.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace treeamr::test
{

/// What a quadrant carries.
struct DyeCell
{
  double concentration; // 0 to 1
  double rate;          // of its change, per unit of time
  double jump;          // the largest difference to a neighbour
};

class Advection
{
public:
  static constexpr std::array<int, 3> trees{ 2, 2, 2 }; // of the unit cube

  /// Collective, as all that is not const. 0 <= minLevel <= maxLevel: of quadrants in their trees.
  Advection(MPI_Comm communicator, int minLevel, int maxLevel);
  ~Advection();
  Advection(const Advection&) = delete;
  Advection& operator=(const Advection&) = delete;

  /// Some steps of time on one forest, then another forest.
  void advance();

  const p8est_t* forest() const noexcept { return forest_; }
  double time() const noexcept { return time_; }
  /// Of libp4est's and the cells' on this process.
  std::size_t memoryBytes() const;

private:
  void findRates();
  void adapt();

  int minLevel_;
  int maxLevel_;
  double time_ = 0.;
  p8est_connectivity_t* connectivity_;
  p8est_t* forest_;
};

} // namespace treeamr::test
