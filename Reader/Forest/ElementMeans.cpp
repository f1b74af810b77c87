#include "Forest/ElementMeans.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace treeamr
{
namespace
{

/// Of Gauss and Lobatto's quadrature over [0, 1] of degree + 1 points, the ends among them: 1 / (n (n + 1) P_n(x)^2) at the
/// roots x of (1 - x^2) P_n'(x), which Newton's method finds from Chebyshev's points.
std::vector<double> lobattoWeights(int degree)
{
  std::vector<double> weights;
  for (int i = 0; i <= degree; ++i)
  {
    double x = -std::cos(std::numbers::pi * i / degree);
    double value = 0.;
    for (int iteration = 0; iteration < 50; ++iteration)
    {
      double before = 1.;
      value = x;
      for (int k = 2; k <= degree; ++k)
      {
        const double next = ((2 * k - 1) * x * value - (k - 1) * before) / k;
        before = value;
        value = next;
      }
      // (1 - x^2) P_n' = n (P_{n-1} - x P_n), whose derivative is -n (n + 1) P_n.
      const double step = (before - x * value) / ((degree + 1) * value);
      x += step;
      if (std::abs(step) < 1e-16)
      {
        break;
      }
    }
    weights.push_back(1. / (degree * (degree + 1) * value * value));
  }
  return weights;
}

/// Of the trapezoidal rule over degree equal parts of [0, 1].
std::vector<double> trapezoidalWeights(int degree)
{
  std::vector<double> weights(degree + 1, 1. / degree);
  weights.front() = weights.back() = 0.5 / degree;
  return weights;
}

/// Products along x, y and z.
std::vector<double> products(const std::vector<double>& x, const std::vector<double>& y)
{
  std::vector<double> all;
  for (const double b : y)
  {
    for (const double a : x)
    {
      all.push_back(a * b);
    }
  }
  return all;
}

std::vector<double> cubed(const std::vector<double>& weights)
{
  return products(products(weights, weights), weights);
}

ElementMean continuous(const std::vector<double>& weights)
{
  const double end = weights.front();
  const std::vector<double> inner(weights.begin() + 1, weights.end() - 1);
  return { { end * end * end }, products(inner, { end * end }), products(products(inner, inner), { end }),
    cubed(inner) };
}

/// One in front of zeros.
ElementMean constantFirst(int count)
{
  ElementMean mean;
  mean.hex.resize(count);
  mean.isInterpolated = false;
  mean.hex[0] = 1.;
  return mean;
}

ElementMean ofQ(int degree)
{
  return continuous(lobattoWeights(degree));
}
ElementMean ofQIsoQ1(int degree)
{
  return continuous(trapezoidalWeights(degree));
}
ElementMean ofQDG0(int degree)
{
  ElementMean mean = ofQ(degree);
  mean.hex.push_back(1.);
  mean.isInterpolated = false;
  return mean;
}
ElementMean ofDGQ(int degree)
{
  return { {}, {}, {}, degree == 0 ? std::vector{ 1. } : cubed(lobattoWeights(degree)) };
}
ElementMean ofDGQLegendre(int degree)
{
  return constantFirst((degree + 1) * (degree + 1) * (degree + 1));
}
ElementMean ofDGP(int degree)
{
  return constantFirst((degree + 1) * (degree + 2) * (degree + 3) / 6);
}

struct KnownElement
{
  std::string_view name;
  int leastDegree;
  ElementMean (*mean)(int degree);
};

constexpr auto knownElements = std::to_array<KnownElement>({
  { "FE_Q", 1, ofQ },
  { "FE_DGQ", 0, ofDGQ },
  { "FE_Q_DG0", 1, ofQDG0 },
  { "FE_Q_iso_Q1", 1, ofQIsoQ1 },
  { "FE_DGP", 0, ofDGP },
  { "FE_DGQLegendre", 0, ofDGQLegendre },
});

} // namespace

std::optional<ElementMean> elementMean(std::string_view name, int degree)
{
  const auto found = std::ranges::find(knownElements, name, &KnownElement::name);
  if (found == knownElements.end() || degree < found->leastDegree)
  {
    return {};
  }
  return found->mean(degree);
}

std::string elementNames()
{
  std::string names;
  for (const KnownElement& element : knownElements)
  {
    names += (names.empty() ? "" : ", ") + std::string(element.name);
  }
  return names;
}

} // namespace treeamr
