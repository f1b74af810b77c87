// Saves a forest of each connectivity that libp4est knows by name, from all processes of MPI.
//
// mpiexec ... save-connectivities FOLDER NAME...
// FOLDER gets NAME.p8est with 8 bytes of payload, the double that is told of each quadrant, NAME-bare.p8est without, and of
// each process NAME.<rank> with its quadrants as eight doubles: tree, value, and two opposite corners as libp4est maps them.
#include <p8est.h>
#include <p8est_extended.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>

namespace
{

std::uint64_t hashOf(p4est_topidx_t tree, const p8est_quadrant_t& q)
{
  std::uint64_t hash = 0x9e3779b97f4a7c15u;
  for (const int part : { int(tree), int(q.level), q.x, q.y, q.z })
  {
    hash = (hash ^ static_cast<std::uint64_t>(part)) * 0xbf58476d1ce4e5b9u;
    hash ^= hash >> 29;
  }
  return hash;
}

double valueOf(p4est_topidx_t tree, const p8est_quadrant_t& q)
{
  return static_cast<double>(hashOf(tree, q) >> 40);
}

int shouldRefine(p8est_t* /*forest*/, p4est_topidx_t tree, p8est_quadrant_t* q)
{
  return q->level < 1 || (q->level < 3 && hashOf(tree, *q) % 3 == 0);
}

void fill(p8est_t* /*forest*/, p4est_topidx_t tree, p8est_quadrant_t* q)
{
  const double value = valueOf(tree, *q);
  std::memcpy(q->p.user_data, &value, sizeof(value));
}

void tellQuadrants(const std::string& path, const p8est_t& forest)
{
  std::ofstream file(path, std::ios::binary);
  for (p4est_topidx_t tree = forest.first_local_tree; tree <= forest.last_local_tree; ++tree)
  {
    sc_array_t& quadrants = p8est_tree_array_index(forest.trees, tree)->quadrants;
    for (std::size_t i = 0; i < quadrants.elem_count; ++i)
    {
      const p8est_quadrant_t& q = *p8est_quadrant_array_index(&quadrants, i);
      const p4est_qcoord_t width = P8EST_QUADRANT_LEN(q.level);
      std::array<double, 8> told{ static_cast<double>(tree), valueOf(tree, q) };
      p8est_qcoord_to_vertex(forest.connectivity, tree, q.x, q.y, q.z, &told[2]);
      p8est_qcoord_to_vertex(forest.connectivity, tree, q.x + width, q.y + width, q.z + width, &told[5]);
      file.write(reinterpret_cast<const char*>(told.data()), sizeof(told));
    }
  }
}

} // namespace

int main(int argc, char** argv)
{
  MPI_Init(&argc, &argv);
  sc_init(MPI_COMM_WORLD, 0, 0, nullptr, SC_LP_ERROR);
  p4est_init(nullptr, SC_LP_ERROR);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  for (int i = 2; i < argc; ++i)
  {
    const std::string path = std::string(argv[1]) + "/" + argv[i];
    p8est_connectivity_t* const connectivity = p8est_connectivity_new_byname(argv[i]);
    p8est_t* const forest = p8est_new(MPI_COMM_WORLD, connectivity, sizeof(double), nullptr, nullptr);
    p8est_refine(forest, 1, shouldRefine, nullptr);
    p8est_balance(forest, P8EST_CONNECT_FACE, nullptr);
    p8est_partition(forest, 0, nullptr);
    p8est_reset_data(forest, sizeof(double), fill, nullptr);
    p8est_save((path + ".p8est").c_str(), forest, 1);
    p8est_save((path + "-bare.p8est").c_str(), forest, 0);
    tellQuadrants(path + "." + std::to_string(rank), *forest);
    p8est_destroy(forest);
    p8est_connectivity_destroy(connectivity);
  }
  sc_finalize();
  MPI_Finalize();
  return 0;
}
