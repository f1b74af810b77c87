#include "FieldError.h"

#include "Convergence.h"
#include "Interpolation/Sampler.h"
#include "Meter.h"
#include "Octree/TreePath.h"
#include "Support/Cameras.h"
#include "Support/RefinedTrees.h"
#include "Surface/SurfaceFrame.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <span>
#include <utility>

namespace treeamr::report
{

using test::AnalyticField;
using test::BaseTree;
using test::gradientOf;
using test::makeBaseTrees;
using test::makeField;

namespace
{

using test::operator-;

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t timedPoints = 20000;

struct NamedMethod
{
  const char* name;
  InterpolationMethod method;
};
constexpr std::array<NamedMethod, 5> methods{ { { "nearest", InterpolationMethod::Nearest },
  { "current", InterpolationMethod::Current }, { "finest", InterpolationMethod::Finest },
  { "octant", InterpolationMethod::Octant }, { "GTI", InterpolationMethod::GTI } } };

constexpr std::array<const char*, 3> regions{ "inside", "near", "away" };

/// At least the width of a root away from the domain's end: no missing cell takes part.
std::vector<Vec3> randomPoints(std::size_t count)
{
  std::mt19937 random(17);
  constexpr double margin = 1. / BaseTree::roots;
  std::uniform_real_distribution<double> inside(margin, 1. - margin);
  std::vector<Vec3> points(count);
  for (Vec3& p : points)
  {
    p = { inside(random), inside(random), inside(random) };
  }
  return points;
}

/// And what it is at the points.
struct KnownField
{
  const char* name;
  AnalyticField field;
  std::vector<double> values = {};
  std::vector<Vec3> gradients = {};
  double longest = 0.; // of the gradients
};

std::vector<KnownField> makeFields(const std::vector<Vec3>& points)
{
  std::vector<KnownField> fields{ { "trilinear",
                                    [](const Vec3& p) {
                                      const auto [x, y, z] = p;
                                      return 0.2 + 0.5 * x - 0.3 * y + 0.4 * z + 0.6 * x * y - 0.7 * y * z +
                                        0.3 * x * z + 0.5 * x * y * z;
                                    } },
    { "quadratic",
      [](const Vec3& p) {
        const auto [x, y, z] = p;
        return 1.5 * (x - 0.3) * (x - 0.3) + (y - 0.6) * (y - 0.6) - 1.2 * (z - 0.5) * (z - 0.5) + x * z;
      } },
    { "smooth",
      [](const Vec3& p) {
        return 0.5 * std::sin(5. * p[0] + 0.3) * std::sin(4. * p[1] + 1.) * std::sin(6. * p[2] + 0.5);
      } },
    { "front", [](const Vec3& p) {
       return 0.5 * std::tanh((std::hypot(p[0] - 0.4, p[1] - 0.35, p[2] - 0.45) - 0.25) / 0.03);
     } } };
  for (KnownField& f : fields)
  {
    for (const Vec3& p : points)
    {
      f.values.push_back(f.field(p));
      f.gradients.push_back(gradientOf(f.field, p));
      f.longest = std::max(f.longest, std::sqrt(dot(f.gradients.back(), f.gradients.back())));
    }
  }
  return fields;
}

/// How the levels of the leaves around a point's leaf differ from its own.
struct Surroundings
{
  bool uniform = true; // they do not
  int coarser = 0;     // levels to the coarsest
};

std::vector<Surroundings> surroundingsOf(const Octree& octree, const std::vector<Vec3>& points)
{
  std::vector<Surroundings> all;
  TreePath path(octree);
  for (Vec3 p : points)
  {
    path.reset();
    while (path.node().isInner())
    {
      int octant = 0;
      for (int a = 0; a < 3; ++a)
      {
        p[a] *= 2.;
        const bool upper = p[a] >= 1.;
        p[a] -= upper;
        octant |= upper << a;
      }
      path.descend(octant);
    }
    Surroundings& around = all.emplace_back();
    for (const NodeRef& node : path.around(path.depth()))
    {
      around.uniform = around.uniform && node.isLeaf() && node.depth() == path.depth();
      around.coarser = std::max(around.coarser, path.depth() - node.depth());
    }
  }
  return all;
}

/// Of the points in one region.
struct RegionErrors
{
  ErrorNorms value;
  ErrorNorms gradient;
  int jump = 0; // most levels to a coarser neighbour
};

std::array<RegionErrors, regions.size()> errorsOf(const Sampler& sampler, const std::vector<Vec3>& points,
  const std::vector<Surroundings>& surroundings, const KnownField& known)
{
  std::array<RegionErrors, regions.size()> errors;
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    FieldSample sample;
    sampler.sample(points[i], sample);
    const Vec3 difference = sample.gradient - known.gradients[i];
    for (RegionErrors* region : { &errors[0], &errors[surroundings[i].uniform ? 2 : 1] })
    {
      region->value.add(std::abs(sample.value - known.values[i]));
      region->gradient.add(std::sqrt(dot(difference, difference)) / known.longest);
      region->jump = std::max(region->jump, surroundings[i].coarser);
    }
  }
  return errors;
}

double cpuSecondsPerQuery(const Sampler& sampler, std::span<const Vec3> points)
{
  double sum = 0.;
  const auto query = [&] {
    FieldSample sample;
    for (const Vec3& p : points)
    {
      sampler.sample(p, sample);
      sum += sample.value;
    }
  };
  const double seconds = bench::best(query).cpu;
  // The sum is looked at, or the queries might be left out.
  return std::isfinite(sum) ? seconds / static_cast<double>(points.size()) : none;
}

/// Of one field, method and region, from coarse to fine.
struct History
{
  std::vector<ErrorNorms> value;
  std::vector<ErrorNorms> gradient;
};
using Histories =
  std::map<std::array<std::size_t, 3>, History>; // by index in known fields, methods and regions

class FieldErrorTable
{
public:
  FieldErrorTable(bool brief, bench::Report& report)
    : points_(randomPoints(brief ? 20000 : 100000))
    , fields_(makeFields(points_))
    , finestRefinement_(brief ? 2 : 4)
    , report_(report)
  {
  }

  void addTree(const BaseTree& tree)
  {
    Histories histories;
    for (int refinement = 0; refinement <= finestRefinement_; ++refinement)
    {
      addRefinement(tree, refinement, histories);
    }
    for (const auto& [key, history] : histories)
    {
      orderRows_.push_back(orderRow(tree, key, history));
    }
  }
  /// The table after that of errors.
  void addOrders(bench::Report& orders)
  {
    for (bench::Row& row : orderRows_)
    {
      orders.add(std::move(row));
    }
  }

private:
  using Key = Histories::key_type;

  void addRefinement(const BaseTree& tree, int refinement, Histories& histories)
  {
    std::vector<Surroundings> surroundings;
    std::array<double, methods.size()> cpuSeconds{}; // the same for all fields
    for (std::size_t f = 0; f < fields_.size(); ++f)
    {
      const std::shared_ptr<const Field> field = makeField(tree, refinement, fields_[f].field);
      const auto cells = static_cast<double>(field->octree().leafCount());
      if (f == 0)
      {
        surroundings = surroundingsOf(field->octree(), points_);
      }
      for (std::size_t m = 0; m < methods.size(); ++m)
      {
        const auto sampler = Sampler::create(methods[m].method, field);
        if (f == 0)
        {
          cpuSeconds[m] = cpuSecondsPerQuery(*sampler, std::span(points_).first(timedPoints));
        }
        const auto errors = errorsOf(*sampler, points_, surroundings, fields_[f]);
        for (std::size_t r = 0; r < regions.size(); ++r)
        {
          if (errors[r].value.count() == 0)
          {
            continue;
          }
          const Key key{ f, m, r };
          report_.add({ tree.name + "-" + std::to_string(refinement),
            errorFigures(tree, refinement, cells, errors[r], cpuSeconds[m]), labels(tree, key) });
          if (refinement >= finestRefinement_ / 2)
          {
            histories[key].value.push_back(errors[r].value);
            histories[key].gradient.push_back(errors[r].gradient);
          }
        }
      }
    }
  }

  static std::vector<bench::Figure> errorFigures(
    const BaseTree& tree, int refinement, double cells, const RegionErrors& errors, double cpuSeconds)
  {
    return {
      { "refinement", static_cast<double>(refinement) },
      { "h", tree.finestWidth(refinement), "h", 5 },
      { "cells", cells, "cells" },
      { "jump", static_cast<double>(errors.jump), "jump" },
      { "points", static_cast<double>(errors.value.count()), "points" },
      { "max_error", errors.value.max(), "1e-6 max", 2, 1e6 },
      { "mean_error", errors.value.mean(), "1e-6 mean", 2, 1e6 },
      { "gradient_max_error", errors.gradient.max(), "gradient max", 5 },
      { "gradient_mean_error", errors.gradient.mean(), "mean", 6 },
      { "ns_per_query", 1e9 * cpuSeconds, "CPU ns" },
    };
  }

  bench::Row orderRow(const BaseTree& tree, const Key& key, const History& history) const
  {
    constexpr double rounding = 1e-6; // of values of unit size as floats, with room
    const bool exact = history.value.front().max() < rounding;
    const ConvergenceOrder value = exact ? ConvergenceOrder{ none, none } : fittedOrder(history.value);
    const ConvergenceOrder gradient = exact ? ConvergenceOrder{ none, none } : fittedOrder(history.gradient);
    return { tree.name,
      { { "order_max", value.ofMax, "max", 2 }, { "order_mean", value.ofMean, "mean", 2 },
        { "order_gradient_max", gradient.ofMax, "gradient max", 2 },
        { "order_gradient_mean", gradient.ofMean, "mean", 2 },
        { "finest_max_error", history.value.back().max(), "1e-6 max", 2, 1e6 },
        { "finest_mean_error", history.value.back().mean(), "1e-6 mean", 2, 1e6 } },
      labels(tree, key) };
  }

  std::vector<std::pair<const char*, std::string>> labels(const BaseTree& tree, const Key& key) const
  {
    return { { "field", fields_[key[0]].name }, { "tree", tree.name }, { "method", methods[key[1]].name },
      { "region", regions[key[2]] } };
  }

  std::vector<Vec3> points_;
  std::vector<KnownField> fields_;
  int finestRefinement_;
  bench::Report& report_;
  std::vector<bench::Row> orderRows_;
};

} // namespace

void measureFieldError(const Options& options, bench::Report& errors, bench::Report& orders)
{
  FieldErrorTable table(options.brief, errors);
  for (const BaseTree& tree : makeBaseTrees())
  {
    table.addTree(tree);
  }
  table.addOrders(orders);
}

} // namespace treeamr::report
