// The program that wrote the checkpoints beside it by Triangulation::save, with deal.II 9.4.1 (Debian 12's libdeal.ii-dev).
// Nothing builds it: deal.II comes with 250 packages. Names of files: NAME, NAME.info and NAME_fixed.data, and of its own
// NAME.txt: x, y and z of each cell's centre and the means over it of all components, by Gauss quadrature.
//
// On two ranks, with an argument that says so:
//   hyper_L    7 of 8 cubes about 0; FE_DGQ(0), FE_Q(1)
//   rectangle  3 x 2 x 1 boxes that are no cubes; a system as of Stokes' equations, and a number a cell
// and on one:
//   cube       (-1, 1)^3; FE_DGQ(0), two vectors of FE_Q(1)
//   elements   others of one component, one vector of float
//   periodic   2 x 1 x 1 cubes, joined at both ends of x and y; FE_DGQ(0)
//   turned     3 x 1 x 1 cubes, the second with its axes cycled, the third turned about z; FE_DGQ(0), FE_Q(2)
//   hp         elements of two degrees, which make data of variable size
//   bare       nothing attached
//   shell      no boxes
#include <deal.II/base/function.h>
#include <deal.II/base/mpi.h>
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/distributed/cell_data_transfer.templates.h>
#include <deal.II/distributed/solution_transfer.h>
#include <deal.II/distributed/tria.h>
#include <deal.II/dofs/dof_handler.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_dgp.h>
#include <deal.II/fe/fe_dgq.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/fe_q_dg0.h>
#include <deal.II/fe/fe_q_iso_q1.h>
#include <deal.II/fe/fe_system.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/grid/grid_generator.h>
#include <deal.II/grid/grid_tools.h>
#include <deal.II/lac/la_parallel_vector.h>
#include <deal.II/numerics/vector_tools.h>

#include <cstdio>
#include <fstream>
#include <map>
#include <memory>

using namespace dealii;
using Mesh = parallel::distributed::Triangulation<3>;

/// Of no symmetry, and in no element's space.
template <class Number>
class Wave : public Function<3, Number>
{
public:
  Wave(unsigned int components, double phase)
    : Function<3, Number>(components)
    , phase_(phase)
  {
  }
  Number value(const Point<3>& p, unsigned int component) const override
  {
    return std::sin(2. * p[0] - 3. * p[1] + p[2] + phase_ + component) + p[0] * p[0] * p[1] * p[2] - 0.25 * p[2];
  }

private:
  double phase_;
};

void refine(Mesh& mesh, double radius, unsigned int times)
{
  for (unsigned int i = 0; i < times; ++i)
  {
    for (const auto& cell : mesh.active_cell_iterators())
    {
      const double distance = cell->center().distance(Point<3>(-0.3, 0.4, 0.2)) - radius;
      if (cell->is_locally_owned() && std::abs(distance) < cell->diameter() * 0.2)
      {
        cell->set_refine_flag();
      }
    }
    mesh.execute_coarsening_and_refinement();
  }
}

/// Attaches vectors to the mesh, and keeps them until it is saved.
class Checkpoint
{
public:
  explicit Checkpoint(Mesh& mesh)
    : mesh_(mesh)
  {
    for (const auto& cell : mesh.active_cell_iterators())
    {
      if (cell->is_locally_owned())
      {
        const Point<3> centre = cell->center();
        rows_[cell->id()] = number(centre[0]) + number(centre[1]) + number(centre[2]);
      }
    }
  }

  template <class Number>
  void attach(const FiniteElement<3>& element, unsigned int vectors)
  {
    using Values = LinearAlgebra::distributed::Vector<Number>;
    struct Kept
    {
      DoFHandler<3> dofs;
      std::vector<Values> values;
      std::unique_ptr<parallel::distributed::SolutionTransfer<3, Values>> transfer;
    };
    const auto kept = std::make_shared<Kept>();
    kept->dofs.reinit(mesh_);
    kept->dofs.distribute_dofs(element);
    IndexSet relevant;
    DoFTools::extract_locally_relevant_dofs(kept->dofs, relevant);
    kept->values.resize(vectors);
    std::vector<const Values*> pointers;
    for (Values& values : kept->values)
    {
      values.reinit(kept->dofs.locally_owned_dofs(), relevant, MPI_COMM_WORLD);
      const Wave<Number> wave(element.n_components(), phase_ += 0.7);
      if (element.has_support_points() && !dynamic_cast<const FE_Q_DG0<3>*>(&element))
      {
        VectorTools::interpolate(kept->dofs, wave, values);
      }
      else // any values will do
      {
        for (const auto i : kept->dofs.locally_owned_dofs())
        {
          values[i] = std::sin(1. + i);
        }
      }
      values.update_ghost_values();
      addMeans(kept->dofs, values);
      pointers.push_back(&values);
    }
    kept->transfer = std::make_unique<parallel::distributed::SolutionTransfer<3, Values>>(kept->dofs);
    kept->transfer->prepare_for_serialization(pointers);
    kept_.push_back(kept);
  }

  void attachNumbers()
  {
    using Transfer = parallel::distributed::CellDataTransfer<3, 3, std::vector<unsigned int>>;
    struct Kept
    {
      std::vector<unsigned int> values;
      std::unique_ptr<Transfer> transfer;
    };
    const auto kept = std::make_shared<Kept>();
    kept->values.resize(mesh_.n_active_cells());
    for (const auto& cell : mesh_.active_cell_iterators())
    {
      if (cell->is_locally_owned())
      {
        kept->values[cell->active_cell_index()] = 1000 * cell->level() + cell->index();
        rows_[cell->id()] += number(kept->values[cell->active_cell_index()]);
      }
    }
    kept->transfer = std::make_unique<Transfer>(mesh_);
    kept->transfer->prepare_for_serialization(kept->values);
    kept_.push_back(kept);
  }

  void save(const std::string& name)
  {
    mesh_.save(name);
    std::string text;
    for (const auto& [id, row] : rows_)
    {
      text += row + '\n';
    }
    const auto all = Utilities::MPI::gather(MPI_COMM_WORLD, text, 0);
    if (Utilities::MPI::this_mpi_process(MPI_COMM_WORLD) == 0)
    {
      std::ofstream table(name + ".txt");
      for (const std::string& part : all)
      {
        table << part;
      }
    }
    std::cout << name << ": " << mesh_.n_global_active_cells() << std::endl;
  }

private:
  static std::string number(double value)
  {
    char text[32];
    std::snprintf(text, sizeof(text), "%.17g ", value);
    return text;
  }

  template <class Values>
  void addMeans(const DoFHandler<3>& dofs, const Values& values)
  {
    const FiniteElement<3>& element = dofs.get_fe();
    // Of a function that is linear in parts, part by part.
    const bool isInParts = dynamic_cast<const FE_Q_iso_Q1<3>*>(&element);
    const QIterated<3> quadrature(QGauss<1>(element.degree + 1), isInParts ? element.degree : 1);
    FEValues<3> fe(element, quadrature, update_values);
    std::vector<Vector<typename Values::value_type>> at(
      quadrature.size(), Vector<typename Values::value_type>(element.n_components()));
    for (const auto& cell : dofs.active_cell_iterators())
    {
      if (cell->is_locally_owned())
      {
        fe.reinit(cell);
        fe.get_function_values(values, at);
        for (unsigned int c = 0; c < element.n_components(); ++c)
        {
          double mean = 0.;
          for (unsigned int q = 0; q < quadrature.size(); ++q)
          {
            mean += quadrature.weight(q) * at[q][c];
          }
          // A quadrature of one point need not have a weight of 1.
          rows_[cell->id()] += number(element.degree == 0 ? at[0][c] : mean);
        }
      }
    }
  }

  Mesh& mesh_;
  double phase_ = 0.;
  std::map<CellId, std::string> rows_;
  std::vector<std::shared_ptr<void>> kept_;
};

void makeTurned(Mesh& mesh)
{
  std::vector<Point<3>> points;
  std::vector<CellData<3>> cells(3);
  const auto point = [](unsigned int x, unsigned int y, unsigned int z) { return x + 4 * (y + 2 * z); };
  for (unsigned int i = 0; i < 16; ++i)
  {
    points.emplace_back(i % 4, i / 4 % 2, i / 8);
  }
  for (unsigned int corner = 0; corner < 8; ++corner)
  {
    const unsigned int x = corner & 1;
    const unsigned int y = corner >> 1 & 1;
    const unsigned int z = corner >> 2;
    cells[0].vertices[corner] = point(x, y, z);
    cells[1].vertices[corner] = point(1 + y, z, x);
    cells[2].vertices[corner] = point(2 + 1 - x, 1 - y, z);
  }
  mesh.create_triangulation(points, cells, SubCellData());
}

void onTwoRanks()
{
  {
    Mesh mesh(MPI_COMM_WORLD);
    GridGenerator::hyper_L(mesh);
    refine(mesh, 0.6, 2);
    Checkpoint checkpoint(mesh);
    checkpoint.attach<double>(FE_DGQ<3>(0), 1);
    checkpoint.attach<double>(FE_Q<3>(1), 1);
    checkpoint.save("hyper_L");
  }
  {
    Mesh mesh(MPI_COMM_WORLD);
    GridGenerator::subdivided_hyper_rectangle(
      mesh, { 3, 2, 1 }, Point<3>(-0.3, 0., 0.1), Point<3>(0.9, 0.7, 0.4));
    refine(mesh, 0.3, 1);
    Checkpoint checkpoint(mesh);
    const FESystem<3> system(FE_Q<3>(2), 3, FE_Q<3>(1), 1, FE_DGQ<3>(1), 1);
    std::cout << system.get_name() << std::endl;
    checkpoint.attach<double>(system, 1);
    checkpoint.attachNumbers();
    checkpoint.save("rectangle");
  }
}

void onOneRank()
{
  {
    Mesh mesh(MPI_COMM_WORLD);
    GridGenerator::hyper_cube(mesh, -1., 1.);
    mesh.refine_global(1);
    refine(mesh, 0.5, 2);
    Checkpoint checkpoint(mesh);
    checkpoint.attach<double>(FE_DGQ<3>(0), 1);
    checkpoint.attach<double>(FE_Q<3>(1), 2);
    checkpoint.save("cube");
  }
  {
    Mesh mesh(MPI_COMM_WORLD);
    GridGenerator::hyper_cube(mesh);
    mesh.refine_global(1);
    Checkpoint checkpoint(mesh);
    checkpoint.attach<double>(FE_Q<3>(4), 1);
    checkpoint.attach<double>(FE_DGQ<3>(3), 1);
    checkpoint.attach<double>(FE_DGP<3>(2), 1);
    checkpoint.attach<double>(FE_Q_DG0<3>(1), 1);
    checkpoint.attach<double>(FE_Q_iso_Q1<3>(3), 1);
    checkpoint.attach<double>(FE_DGQLegendre<3>(1), 1);
    checkpoint.attach<float>(FE_Q<3>(2), 1);
    checkpoint.save("elements");
  }
  {
    Mesh mesh(MPI_COMM_WORLD);
    GridGenerator::subdivided_hyper_rectangle(
      mesh, { 2, 1, 1 }, Point<3>(0., 0., 0.), Point<3>(2., 1., 1.), true);
    std::vector<GridTools::PeriodicFacePair<Mesh::cell_iterator>> pairs;
    GridTools::collect_periodic_faces(mesh, 0, 1, 0, pairs);
    GridTools::collect_periodic_faces(mesh, 2, 3, 1, pairs);
    mesh.add_periodicity(pairs);
    refine(mesh, 0.6, 2);
    Checkpoint checkpoint(mesh);
    checkpoint.attach<double>(FE_DGQ<3>(0), 1);
    checkpoint.save("periodic");
  }
  {
    Mesh mesh(MPI_COMM_WORLD);
    makeTurned(mesh);
    mesh.refine_global(1);
    refine(mesh, 1.5, 1);
    Checkpoint checkpoint(mesh);
    checkpoint.attach<double>(FE_DGQ<3>(0), 1);
    checkpoint.attach<double>(FE_Q<3>(2), 1);
    checkpoint.save("turned");
  }
  {
    Mesh mesh(MPI_COMM_WORLD);
    GridGenerator::hyper_cube(mesh);
    mesh.refine_global(1);
    hp::FECollection<3> elements(FE_Q<3>(1), FE_Q<3>(2));
    DoFHandler<3> dofs(mesh);
    for (const auto& cell : dofs.active_cell_iterators())
    {
      cell->set_active_fe_index(cell->index() % 2);
    }
    dofs.distribute_dofs(elements);
    LinearAlgebra::distributed::Vector<double> values(
      dofs.locally_owned_dofs(), dofs.locally_owned_dofs(), MPI_COMM_WORLD);
    parallel::distributed::SolutionTransfer<3, LinearAlgebra::distributed::Vector<double>> transfer(dofs);
    Checkpoint checkpoint(mesh);
    checkpoint.attach<double>(FE_DGQ<3>(0), 1);
    transfer.prepare_for_serialization(values);
    checkpoint.save("hp");
  }
  {
    Mesh mesh(MPI_COMM_WORLD);
    GridGenerator::subdivided_hyper_cube(mesh, 2);
    Checkpoint(mesh).save("bare");
  }
  {
    Mesh mesh(MPI_COMM_WORLD);
    GridGenerator::hyper_shell(mesh, Point<3>(), 0.5, 1., 6);
    Checkpoint checkpoint(mesh);
    checkpoint.attach<double>(FE_DGQ<3>(0), 1);
    checkpoint.save("shell");
  }
}

int main(int argc, char** argv)
{
  const Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  if (argc > 1)
  {
    onTwoRanks();
  }
  else
  {
    onOneRank();
  }
}
