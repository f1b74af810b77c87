#include "InSitu/Advection.h"

#include <p8est_bits.h>
#include <p8est_connectivity.h>
#include <p8est_extended.h>
#include <p8est_ghost.h>
#include <p8est_iterate.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace treeamr::test
{
namespace
{

using Point = std::array<double, 3>;

constexpr double refineAbove = 0.04;
constexpr double coarsenBelow = 0.01;
constexpr double courantNumber = 0.4;
constexpr double fastest = 2.; // component of the flow
constexpr int stepsPerForest = 4;

Point velocity(const Point& p)
{
  using std::numbers::pi;
  std::array<double, 3> single; // sin^2(pi x)
  std::array<double, 3> twice;  // sin(2 pi x)
  for (int a = 0; a < 3; ++a)
  {
    const double sine = std::sin(pi * p[a]);
    single[a] = sine * sine;
    twice[a] = std::sin(2. * pi * p[a]);
  }
  return { 2. * single[0] * twice[1] * twice[2], -twice[0] * single[1] * twice[2],
    -twice[0] * twice[1] * single[2] };
}

double dyeAtFirst(const Point& p)
{
  constexpr double radius = 0.15;
  constexpr double width = 0.03; // of its border
  const double distance = std::hypot(p[0] - 0.35, p[1] - 0.35, p[2] - 0.35);
  return 0.5 * (1. - std::tanh((distance - radius) / width));
}

DyeCell& cellOf(p8est_quadrant_t* quadrant)
{
  return *static_cast<DyeCell*>(quadrant->p.user_data);
}

/// Of one as wide as its tree: 1.
double widthOf(const p8est_quadrant_t& quadrant)
{
  return std::exp2(-quadrant.level);
}

Point centreOf(const p8est_t* forest, p4est_topidx_t tree, const p8est_quadrant_t& quadrant)
{
  const p4est_qcoord_t half = P8EST_QUADRANT_LEN(quadrant.level) / 2;
  Point centre;
  p8est_qcoord_to_vertex(
    forest->connectivity, tree, quadrant.x + half, quadrant.y + half, quadrant.z + half, centre.data());
  return centre;
}

void setFirst(p8est_t* forest, p4est_topidx_t tree, p8est_quadrant_t* quadrant)
{
  cellOf(quadrant) = { dyeAtFirst(centreOf(forest, tree, *quadrant)), 0., 0. };
}

/// One or eight cells of a side, here or another process's.
struct Side
{
  Side(p8est_iter_face_side_t* side, DyeCell* ghosts)
    : count(side->is_hanging ? P8EST_HALF : 1)
    , isHanging(side->is_hanging)
  {
    for (int i = 0; i < count; ++i)
    {
      const bool isGhost = side->is_hanging ? side->is.hanging.is_ghost[i] : side->is.full.is_ghost;
      const p4est_locidx_t number = side->is_hanging ? side->is.hanging.quadid[i] : side->is.full.quadid;
      quadrants[i] = side->is_hanging ? side->is.hanging.quad[i] : side->is.full.quad;
      // Of a larger one's four neighbours those that touch no cell of this process may be unknown.
      cells[i] = !quadrants[i] ? nullptr : isGhost ? &ghosts[number] : &cellOf(quadrants[i]);
    }
  }

  int count;
  bool isHanging;
  std::array<p8est_quadrant_t*, P8EST_HALF> quadrants{};
  std::array<DyeCell*, P8EST_HALF> cells{};
};

/// What flows through a face, from upwind, to the rates of the cells on both sides.
void flow(p8est_iter_face_info_t* info, void* ghosts)
{
  if (info->sides.elem_count < 2)
  {
    return; // a wall, where nothing flows
  }
  auto* const first = p8est_iter_fside_array_index_int(&info->sides, 0);
  auto* const second = p8est_iter_fside_array_index_int(&info->sides, 1);
  const std::array<Side, 2> sides{ Side(first, static_cast<DyeCell*>(ghosts)),
    Side(second, static_cast<DyeCell*>(ghosts)) };
  // The trees of a brick are all along the same axes: a face is seen from both sides alike.
  const Side& finer = sides[sides[1].isHanging ? 1 : 0];
  const auto* const seenFrom = sides[1].isHanging ? second : first;
  const int axis = first->face / 2;
  const double outwards = first->face % 2 == 0 ? -1. : 1.; // of the first side
  for (int i = 0; i < finer.count; ++i)
  {
    if (!finer.quadrants[i])
    {
      continue;
    }
    const p8est_quadrant_t& quadrant = *finer.quadrants[i];
    const double width = widthOf(quadrant);
    Point at = centreOf(info->p4est, seenFrom->treeid, quadrant);
    at[axis] += (seenFrom->face % 2 == 0 ? -0.5 : 0.5) * width / Advection::trees[axis];
    std::array<int, 2> number; // of the cell on each side
    for (int s = 0; s < 2; ++s)
    {
      number[s] = sides[s].isHanging ? i : 0;
    }
    DyeCell& a = *sides[0].cells[number[0]];
    DyeCell& b = *sides[1].cells[number[1]];
    const double speed = outwards * velocity(at)[axis];
    const double flux =
      speed * (speed > 0. ? a.concentration : b.concentration) * width * width * Advection::trees[axis];
    a.rate -= flux / std::pow(widthOf(*sides[0].quadrants[number[0]]), 3);
    b.rate += flux / std::pow(widthOf(*sides[1].quadrants[number[1]]), 3);
    const double jump = std::abs(a.concentration - b.concentration);
    a.jump = std::max(a.jump, jump);
    b.jump = std::max(b.jump, jump);
  }
}

template <class Visit>
void visitCells(p8est_t* forest, const Visit& visit)
{
  for (p4est_topidx_t t = forest->first_local_tree; t <= forest->last_local_tree; ++t)
  {
    sc_array_t* const quadrants = &p8est_tree_array_index(forest->trees, t)->quadrants;
    for (std::size_t i = 0; i < quadrants->elem_count; ++i)
    {
      visit(p8est_quadrant_array_index(quadrants, i));
    }
  }
}

int callRefine(p8est_t*, p4est_topidx_t, p8est_quadrant_t* quadrant)
{
  return cellOf(quadrant).jump > refineAbove;
}

int callCoarsen(p8est_t* forest, p4est_topidx_t, p8est_quadrant_t* family[])
{
  const int minLevel = *static_cast<const int*>(forest->user_pointer);
  return family[0]->level > minLevel && std::all_of(family, family + P8EST_CHILDREN, [](p8est_quadrant_t* one) {
    return cellOf(one).jump < coarsenBelow;
  });
}

/// One by eight or eight by one: the dye stays.
void callReplace(p8est_t*, p4est_topidx_t, int leaving, p8est_quadrant_t* old[], int coming,
  p8est_quadrant_t* fresh[])
{
  DyeCell mean{};
  for (int i = 0; i < leaving; ++i)
  {
    mean.concentration += cellOf(old[i]).concentration / leaving;
    mean.jump = std::max(mean.jump, cellOf(old[i]).jump);
  }
  std::for_each(fresh, fresh + coming, [&](p8est_quadrant_t* one) { cellOf(one) = mean; });
}

} // namespace

Advection::Advection(MPI_Comm communicator, int minLevel, int maxLevel)
  : minLevel_(minLevel)
  , maxLevel_(maxLevel)
  , connectivity_(p8est_connectivity_new_brick(trees[0], trees[1], trees[2], 0, 0, 0))
{
  for (p4est_topidx_t i = 0; i < 3 * connectivity_->num_vertices; ++i)
  {
    connectivity_->vertices[i] /= trees[i % 3];
  }
  forest_ = p8est_new_ext(
    communicator, connectivity_, 0, minLevel, 1, sizeof(DyeCell), setFirst, &minLevel_);
  for (int level = minLevel; level < maxLevel; ++level)
  {
    findRates();
    adapt();
    visitCells(forest_, [](p8est_quadrant_t* one) { cellOf(one).jump = 0.; });
    p8est_reset_data(forest_, sizeof(DyeCell), setFirst, &minLevel_);
  }
}

Advection::~Advection()
{
  p8est_destroy(forest_);
  p8est_connectivity_destroy(connectivity_);
}

void Advection::findRates()
{
  visitCells(forest_, [](p8est_quadrant_t* one) { cellOf(one).rate = cellOf(one).jump = 0.; });
  p8est_ghost_t* const layer = p8est_ghost_new(forest_, P8EST_CONNECT_FACE);
  std::vector<DyeCell> ghosts(layer->ghosts.elem_count);
  p8est_ghost_exchange_data(forest_, layer, ghosts.data());
  p8est_iterate(forest_, layer, ghosts.data(), nullptr, flow, nullptr, nullptr);
  p8est_ghost_destroy(layer);
}

void Advection::adapt()
{
  p8est_refine_ext(forest_, 0, maxLevel_, callRefine, nullptr, callReplace);
  p8est_coarsen_ext(forest_, 0, 0, callCoarsen, nullptr, callReplace);
  p8est_balance_ext(forest_, P8EST_CONNECT_FULL, nullptr, callReplace);
  p8est_partition(forest_, 1, nullptr); // families stay together, so that any number of processes has the same forest
}

void Advection::advance()
{
  const double step = courantNumber * std::exp2(-maxLevel_) / trees[0] / fastest;
  for (int i = 0; i < stepsPerForest; ++i)
  {
    findRates();
    visitCells(forest_, [step](p8est_quadrant_t* one) { cellOf(one).concentration += step * cellOf(one).rate; });
    time_ += step;
  }
  adapt();
}

std::size_t Advection::memoryBytes() const
{
  return p8est_memory_used(forest_);
}

} // namespace treeamr::test
