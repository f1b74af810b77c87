#include "Support/PlanarForest.h"

#include "Support/P4estSession.h"

#include <p4est.h>
#include <p4est_extended.h>

#include <cstring>
#include <fstream>
#include <stdexcept>

namespace treeamr::test
{

namespace
{

/// Different for each quadrant.
double valueOf(p4est_topidx_t tree, const p4est_quadrant_t& quadrant)
{
  return tree + 0.25 * quadrant.x / P4EST_ROOT_LEN + 0.0625 * quadrant.y / P4EST_ROOT_LEN +
    1000. * quadrant.level;
}

struct Refinement
{
  int maxLevel;
  int oneIn;
};

int shouldRefine(p4est_t* forest, p4est_topidx_t tree, p4est_quadrant_t* quadrant)
{
  const auto& refinement = *static_cast<const Refinement*>(forest->user_pointer);
  const std::uint64_t place =
    static_cast<std::uint64_t>(quadrant->x) << 32 ^ static_cast<std::uint64_t>(quadrant->y);
  const std::uint64_t hash =
    (place ^ static_cast<std::uint64_t>(31 * tree + quadrant->level)) * 0x9e3779b97f4a7c15u;
  return quadrant->level < refinement.maxLevel &&
    (hash >> 40) % static_cast<std::uint64_t>(refinement.oneIn) == 0;
}

} // namespace

struct PlanarForest::Impl
{
  explicit Impl(p4est_connectivity_t* c)
    : connectivity(c)
  {
    if (!connectivity)
    {
      throw std::runtime_error("libp4est knows no such connectivity");
    }
    forest = p4est_new(MPI_COMM_SELF, connectivity, sizeof(double), nullptr, nullptr);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl()
  {
    p4est_destroy(forest);
    p4est_connectivity_destroy(connectivity);
  }

  template <class Visit>
  void forEach(const Visit& visit) const
  {
    for (p4est_topidx_t t = forest->first_local_tree; t <= forest->last_local_tree; ++t)
    {
      sc_array_t& quadrants = p4est_tree_array_index(forest->trees, t)->quadrants;
      for (std::size_t i = 0; i < quadrants.elem_count; ++i)
      {
        visit(t, *p4est_quadrant_array_index(&quadrants, i));
      }
    }
  }

  p4est_connectivity_t* connectivity;
  p4est_t* forest;
};

PlanarForest::PlanarForest(std::shared_ptr<Impl> impl)
  : impl_(std::move(impl))
{
}

PlanarForest PlanarForest::brick(int x, int y)
{
  startP4est();
  return PlanarForest(std::make_shared<Impl>(p4est_connectivity_new_brick(x, y, 0, 0)));
}

PlanarForest PlanarForest::named(const std::string& name)
{
  startP4est();
  return PlanarForest(std::make_shared<Impl>(p4est_connectivity_new_byname(name.c_str())));
}

void PlanarForest::moveCorners(const std::function<Point(int, int, const Point&)>& move)
{
  p4est_connectivity_t& connectivity = *impl_->connectivity;
  const p4est_topidx_t corners = 4 * connectivity.num_trees;
  auto* const vertices = P4EST_ALLOC(double, 3 * corners);
  for (p4est_topidx_t i = 0; i < corners; ++i)
  {
    const double* const v = connectivity.vertices + 3 * connectivity.tree_to_vertex[i];
    const Point moved = move(i / 4, i % 4, { v[0], v[1], v[2] });
    std::memcpy(vertices + 3 * i, moved.data(), sizeof(moved));
  }
  P4EST_FREE(connectivity.vertices);
  connectivity.vertices = vertices;
  connectivity.num_vertices = corners;
  for (p4est_topidx_t i = 0; i < corners; ++i)
  {
    connectivity.tree_to_vertex[i] = i;
  }
}

void PlanarForest::dropVertices()
{
  p4est_connectivity_t& connectivity = *impl_->connectivity;
  P4EST_FREE(connectivity.vertices);
  P4EST_FREE(connectivity.tree_to_vertex);
  connectivity.vertices = nullptr;
  connectivity.tree_to_vertex = nullptr;
  connectivity.num_vertices = 0;
}

void PlanarForest::refineAtRandom(int maxLevel, int oneIn)
{
  Refinement refinement{ maxLevel, oneIn };
  impl_->forest->user_pointer = &refinement;
  p4est_refine(impl_->forest, 1, shouldRefine, nullptr);
  impl_->forest->user_pointer = nullptr;
  impl_->forEach([](p4est_topidx_t tree, p4est_quadrant_t& quadrant) {
    const double value = valueOf(tree, quadrant);
    std::memcpy(quadrant.p.user_data, &value, sizeof(value));
  });
}

std::vector<PlanarForest::Quadrant> PlanarForest::quadrants() const
{
  std::vector<Quadrant> all;
  impl_->forEach([&](p4est_topidx_t tree, const p4est_quadrant_t& quadrant) {
    Quadrant& q = all.emplace_back(Quadrant{ tree, quadrant.level, {}, valueOf(tree, quadrant) });
    for (int i = 0; i < 2; ++i)
    {
      const p4est_qcoord_t width = i * P4EST_QUADRANT_LEN(quadrant.level);
      p4est_qcoord_to_vertex(
        impl_->connectivity, tree, quadrant.x + width, quadrant.y + width, q.corners[i].data());
    }
  });
  return all;
}

void PlanarForest::save(const std::string& path, bool withPayload) const
{
  if (!std::ofstream(path, std::ios::binary)) // libp4est would end the process
  {
    throw std::runtime_error(path + " cannot be written");
  }
  p4est_save(path.c_str(), impl_->forest, withPayload);
}

} // namespace treeamr::test
