// The program that wrote the files beside it, with deal.II 9.4.1 (Debian 12's libdeal.ii-dev) on two ranks. Nothing builds it:
// deal.II comes with 250 packages.
//
//   cube_0.pvtu       hyper_cube(-1, 1), refined where a sphere is, a cell as one
//   rectangle_0.pvtu  3 x 2 x 1 boxes that are no cubes, a cell as 3 x 3 x 3
//   hyper_L_0.pvtu    seven of eight cubes, a cell as 2 x 2 x 2
//
// All have the point arrays "wave", a trilinear function in FE_Q(1), and "level", which was a value a cell.
#include <deal.II/base/function.h>
#include <deal.II/base/mpi.h>
#include <deal.II/distributed/tria.h>
#include <deal.II/dofs/dof_handler.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/grid/grid_generator.h>
#include <deal.II/lac/la_parallel_vector.h>
#include <deal.II/numerics/data_out.h>
#include <deal.II/numerics/vector_tools.h>

using namespace dealii;

double wave(const Point<3>& p)
{
  return 0.5 + p[0] + 2. * p[1] - p[2] + 3. * p[0] * p[1] * p[2]; // trilinear
}

class Wave : public Function<3>
{
public:
  double value(const Point<3>& p, unsigned int) const override { return wave(p); }
};

using Solution = LinearAlgebra::distributed::Vector<double>;

void write(parallel::distributed::Triangulation<3>& mesh, const std::string& name, unsigned int levels,
  unsigned int patches)
{
  for (unsigned int level = 0; level < levels; ++level)
  {
    for (const auto& cell : mesh.active_cell_iterators())
    {
      const double distance = cell->center().norm() - 0.6;
      if (cell->is_locally_owned() && std::abs(distance) < cell->diameter() * 0.3)
      {
        cell->set_refine_flag();
      }
    }
    mesh.execute_coarsening_and_refinement();
  }
  FE_Q<3> element(1);
  DoFHandler<3> dofs(mesh);
  dofs.distribute_dofs(element);
  IndexSet relevant;
  DoFTools::extract_locally_relevant_dofs(dofs, relevant);
  Solution solution(dofs.locally_owned_dofs(), relevant, MPI_COMM_WORLD);
  VectorTools::interpolate(dofs, Wave(), solution);
  solution.update_ghost_values();
  Vector<float> levelOf(mesh.n_active_cells());
  for (const auto& cell : mesh.active_cell_iterators())
  {
    if (cell->is_locally_owned())
    {
      levelOf[cell->active_cell_index()] = cell->level();
    }
  }
  DataOut<3> out;
  out.attach_dof_handler(dofs);
  out.add_data_vector(solution, "wave");
  out.add_data_vector(levelOf, "level");
  out.build_patches(patches);
  out.write_vtu_with_pvtu_record("./", name, 0, MPI_COMM_WORLD, 0);
  std::cout << name << ": " << mesh.n_global_active_cells() << std::endl;
}

int main(int argc, char** argv)
{
  const Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  {
    parallel::distributed::Triangulation<3> mesh(MPI_COMM_WORLD);
    GridGenerator::hyper_cube(mesh, -1., 1.);
    mesh.refine_global(2);
    write(mesh, "cube", 1, 1);
  }
  {
    parallel::distributed::Triangulation<3> mesh(MPI_COMM_WORLD);
    GridGenerator::subdivided_hyper_rectangle(
      mesh, { 3, 2, 1 }, Point<3>(-0.3, 0., 0.1), Point<3>(0.9, 0.7, 0.4));
    write(mesh, "rectangle", 1, 3);
  }
  {
    parallel::distributed::Triangulation<3> mesh(MPI_COMM_WORLD);
    GridGenerator::hyper_L(mesh);
    write(mesh, "hyper_L", 1, 2);
  }
}
