// libp4est keeps callbacks as plain functions with a user pointer, which here leads to a std::function.
#include "Support/ForestWriter.h"

#include "Support/P4estSession.h"

#include <p8est.h>
#include <p8est_extended.h>
#include <p8est_vtk.h>

#include <cstring>
#include <fstream>
#include <map>
#include <stdexcept>

namespace treeamr::test
{
namespace
{

ForestQuadrant describe(int tree, const p8est_quadrant_t& quadrant)
{
  const int shift = P8EST_MAXLEVEL - quadrant.level;
  const auto index = [&](p4est_qcoord_t x) { return static_cast<std::uint32_t>(x >> shift); };
  return { tree, { index(quadrant.x), index(quadrant.y), index(quadrant.z) }, quadrant.level, {} };
}

using RefineCallback = std::function<bool(const ForestQuadrant&)>;
using FillCallback = std::function<void(const ForestQuadrant&, std::byte*)>;

int callRefine(p8est_t* forest, p4est_topidx_t tree, p8est_quadrant_t* quadrant)
{
  return (*static_cast<const RefineCallback*>(forest->user_pointer))(describe(tree, *quadrant));
}

void callFill(p8est_t* forest, p4est_topidx_t tree, p8est_quadrant_t* quadrant)
{
  (*static_cast<const FillCallback*>(forest->user_pointer))(
    describe(tree, *quadrant), static_cast<std::byte*>(quadrant->p.user_data));
}

} // namespace

struct ForestWriter::Impl
{
  explicit Impl(p8est_connectivity_t* c)
    : connectivity(c)
  {
    if (!connectivity)
    {
      throw std::runtime_error("libp4est knows no such connectivity");
    }
    forest = p8est_new(MPI_COMM_SELF, connectivity, 0, nullptr, nullptr);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl()
  {
    p8est_destroy(forest);
    p8est_connectivity_destroy(connectivity);
  }
  p8est_connectivity_t* connectivity;
  p8est_t* forest;
};

const int ForestWriter::maxLevel = P8EST_QMAXLEVEL;

ForestWriter::ForestWriter(std::shared_ptr<Impl> impl)
  : impl_(std::move(impl))
{
}

ForestWriter ForestWriter::unitCube()
{
  startP4est();
  return ForestWriter(std::make_shared<Impl>(p8est_connectivity_new_unitcube()));
}

ForestWriter ForestWriter::brick(std::array<int, 3> trees, std::array<bool, 3> periodic)
{
  startP4est();
  return ForestWriter(std::make_shared<Impl>(
    p8est_connectivity_new_brick(trees[0], trees[1], trees[2], periodic[0], periodic[1], periodic[2])));
}

ForestWriter ForestWriter::named(const std::string& name)
{
  startP4est();
  return ForestWriter(std::make_shared<Impl>(p8est_connectivity_new_byname(name.c_str())));
}

ForestWriter ForestWriter::separateTrees(const std::vector<Corners>& trees)
{
  startP4est();
  const auto count = static_cast<p4est_topidx_t>(trees.size());
  p8est_connectivity_t* connectivity = p8est_connectivity_new(8 * count, count, 0, 0, 0, 0);
  for (p4est_topidx_t tree = 0; tree < count; ++tree)
  {
    for (int corner = 0; corner < 8; ++corner)
    {
      connectivity->tree_to_vertex[8 * tree + corner] = 8 * tree + corner;
      std::memcpy(
        connectivity->vertices + 3 * (8 * tree + corner), trees[tree][corner].data(), sizeof(Point));
    }
    for (int face = 0; face < 6; ++face) // itself: no neighbour
    {
      connectivity->tree_to_tree[6 * tree + face] = tree;
      connectivity->tree_to_face[6 * tree + face] = static_cast<std::int8_t>(face);
    }
  }
  return ForestWriter(std::make_shared<Impl>(connectivity));
}

ForestWriter ForestWriter::joinedTrees(const std::vector<Corners>& trees)
{
  std::map<Point, p4est_topidx_t> vertices;
  for (const Corners& corners : trees)
  {
    for (const Point& corner : corners)
    {
      vertices.emplace(corner, static_cast<p4est_topidx_t>(vertices.size()));
    }
  }
  ForestWriter forest = separateTrees(trees);
  p8est_connectivity_t* connectivity = forest.impl_->connectivity;
  for (std::size_t i = 0; i < 8 * trees.size(); ++i)
  {
    connectivity->tree_to_vertex[i] = vertices[trees[i / 8][i % 8]];
  }
  for (const auto& [at, vertex] : vertices)
  {
    std::memcpy(connectivity->vertices + 3 * vertex, at.data(), sizeof(Point));
  }
  p8est_connectivity_complete(connectivity);
  return forest;
}

ForestWriter ForestWriter::withoutVertices()
{
  startP4est();
  p8est_connectivity_t* connectivity = p8est_connectivity_new(0, 1, 0, 0, 0, 0);
  for (int face = 0; face < 6; ++face)
  {
    connectivity->tree_to_tree[face] = 0;
    connectivity->tree_to_face[face] = static_cast<std::int8_t>(face);
  }
  return ForestWriter(std::make_shared<Impl>(connectivity));
}

void ForestWriter::moveVertices(const std::function<Point(const Point&)>& move)
{
  for (p4est_topidx_t vertex = 0; vertex < impl_->connectivity->num_vertices; ++vertex)
  {
    double* const v = impl_->connectivity->vertices + 3 * vertex;
    const Point moved = move({ v[0], v[1], v[2] });
    std::memcpy(v, moved.data(), sizeof(moved));
  }
}

void ForestWriter::dropVertices()
{
  p8est_connectivity_t& connectivity = *impl_->connectivity;
  P4EST_FREE(connectivity.vertices);
  P4EST_FREE(connectivity.tree_to_vertex);
  connectivity.vertices = nullptr;
  connectivity.tree_to_vertex = nullptr;
  connectivity.num_vertices = 0;
}

void ForestWriter::setTreeAttributes(std::size_t bytesPerTree)
{
  p8est_connectivity_set_attr(impl_->connectivity, bytesPerTree);
  std::memset(impl_->connectivity->tree_to_attr, 0x5a,
    bytesPerTree * static_cast<std::size_t>(impl_->connectivity->num_trees));
}

void ForestWriter::refine(const RefineCallback& shouldRefine)
{
  impl_->forest->user_pointer = const_cast<RefineCallback*>(&shouldRefine);
  p8est_refine(impl_->forest, 1, callRefine, nullptr);
  impl_->forest->user_pointer = nullptr;
}

void ForestWriter::balance(Balance balance)
{
  const p8est_connect_type_t types[] = { P8EST_CONNECT_FACE, P8EST_CONNECT_EDGE, P8EST_CONNECT_FULL };
  p8est_balance(impl_->forest, types[static_cast<int>(balance)], nullptr);
}

void ForestWriter::setPayload(std::size_t bytes, const FillCallback& fill)
{
  p8est_reset_data(impl_->forest, bytes, callFill, const_cast<FillCallback*>(&fill));
  impl_->forest->user_pointer = nullptr;
}

std::vector<ForestQuadrant> ForestWriter::quadrants() const
{
  std::vector<ForestQuadrant> all;
  all.reserve(static_cast<std::size_t>(quadrantCount()));
  const p8est_t& forest = *impl_->forest;
  for (p4est_topidx_t t = forest.first_local_tree; t <= forest.last_local_tree; ++t)
  {
    sc_array_t& quadrants = p8est_tree_array_index(forest.trees, t)->quadrants;
    for (std::size_t i = 0; i < quadrants.elem_count; ++i)
    {
      const p8est_quadrant_t& quadrant = *p8est_quadrant_array_index(&quadrants, i);
      all.push_back(describe(t, quadrant));
      if (forest.data_size > 0)
      {
        const auto* const data = static_cast<const std::byte*>(quadrant.p.user_data);
        all.back().payload.assign(data, data + forest.data_size);
      }
    }
  }
  return all;
}

std::int64_t ForestWriter::quadrantCount() const
{
  return impl_->forest->global_num_quadrants;
}

std::array<ForestWriter::Point, 2> ForestWriter::bounds(const ForestQuadrant& quadrant) const
{
  std::array<Point, 2> corners;
  for (std::uint32_t i = 0; i < 2; ++i)
  {
    std::array<p4est_qcoord_t, 3> at;
    for (int a = 0; a < 3; ++a)
    {
      at[a] = static_cast<p4est_qcoord_t>((quadrant.index[a] + i) << (P8EST_MAXLEVEL - quadrant.level));
    }
    p8est_qcoord_to_vertex(impl_->connectivity, quadrant.tree, at[0], at[1], at[2], corners[i].data());
  }
  return corners;
}

void ForestWriter::save(const std::string& path, bool withPayload) const
{
  if (!std::ofstream(path, std::ios::binary)) // libp4est would end the process
  {
    throw std::runtime_error(path + " cannot be written");
  }
  p8est_save(path.c_str(), impl_->forest, withPayload);
}

void ForestWriter::saveVtk(
  const std::string& prefix, const std::string& name, const std::vector<double>& values, double scale) const
{
  p8est_vtk_context_t* context = p8est_vtk_context_new(impl_->forest, prefix.c_str());
  p8est_vtk_context_set_scale(context, scale);
  p8est_vtk_context_set_continuous(context, scale == 1.);
  context = p8est_vtk_write_header(context);
  sc_array_t* array = sc_array_new_data(const_cast<double*>(values.data()), sizeof(double), values.size());
  context =
    context ? p8est_vtk_write_cell_dataf(context, 1, 1, 1, 0, 1, 0, name.c_str(), array, context) : nullptr;
  sc_array_destroy(array);
  if (!context || p8est_vtk_write_footer(context) != 0)
  {
    throw std::runtime_error(prefix + ".pvtu cannot be written");
  }
}

void ForestWriter::saveConnectivity(const std::string& path) const
{
  if (p8est_connectivity_save(path.c_str(), impl_->connectivity) != 0)
  {
    throw std::runtime_error(path + " cannot be written");
  }
}

} // namespace treeamr::test
