// The formulas are those of vtkColorTransferFunction and vtkMath; the interpolation between diverging colours is that of
// Moreland, "Diverging Color Maps for Scientific Visualization", 2009. Loops over values are written to be vectorised:
// no calls, no branches.
#include "ColorCurve.h"

#include "vtkMath.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace treeamr
{

namespace
{

constexpr std::size_t most = ColorCurve::most;

/// x^(-1/12) of positive normal numbers by Newton's method, from an estimate by the bits of floats.
[[gnu::always_inline]] inline float inverseTwelfthRoot(float x)
{
  const auto bits = std::bit_cast<std::int32_t>(x);
  constexpr std::int32_t ofOne = 0x3f800000;
  // Bits are logarithms, a little below: lowered as much, it errs by 3 % at most from 0.003 to 1.6.
  constexpr std::int32_t lower = 440000;
  const auto twelfth = static_cast<std::int32_t>(static_cast<float>(bits - ofOne) * (-1.f / 12.f));
  float y = std::bit_cast<float>(ofOne - lower + twelfth);
  for (int step = 0; step < 3; ++step)
  {
    const float y2 = y * y;
    const float y4 = y2 * y2;
    y += y * (1.f - x * y4 * y4 * y4) * (1.f / 12.f);
  }
  return y;
}

/// sRGB's gamma, 2.4, of linear light.
[[gnu::always_inline]] inline float withGamma(float x)
{
  constexpr float threshold = 0.0031308f;
  const float light = std::max(x, threshold);
  const float y = inverseTwelfthRoot(light);
  const float y3 = y * y * y;
  const float power = light * y3 * y3 * y; // x^(5/12)
  return x > threshold ? 1.055f * power - 0.055f : 12.92f * x;
}

[[gnu::always_inline]] inline float fromLab(float x)
{
  const float cube = x * x * x;
  return cube > 0.008856f ? cube : (x - 16.f / 116.f) * (1.f / 7.787f);
}

/// Sine of angles of few turns.
[[gnu::always_inline]] inline float sine(float angle)
{
  constexpr float pi = std::numbers::pi_v<float>;
  const float halfTurns = angle * (1.f / pi);
  const auto nearest = static_cast<std::int32_t>(halfTurns + (halfTurns < 0.f ? -0.5f : 0.5f));
  // pi in two parts: the first one's products have no rounding.
  constexpr float high = 3.140625f;
  constexpr float low = static_cast<float>(std::numbers::pi - 3.140625);
  const auto whole = static_cast<float>(nearest);
  const float x = (angle - whole * high) - whole * low;
  const float square = x * x;
  const float odd = x +
    x * square *
      (-1.f / 6.f +
        square *
          (1.f / 120.f +
            square * (-1.f / 5040.f + square * (1.f / 362880.f + square * (-1.f / 39916800.f)))));
  return (nearest & 1) != 0 ? -odd : odd;
}

/// Red, green and blue from CIELAB, in place, as vtkMath::LabToRGB() clips them.
[[gnu::always_inline]] inline void labToRgb(ColorCurve::Colors& colors, std::size_t count)
{
  float* const first = colors.channel[0];
  float* const second = colors.channel[1];
  float* const third = colors.channel[2];
  for (std::size_t i = 0; i < count; ++i)
  {
    const float lightness = (first[i] + 16.f) * (1.f / 116.f);
    const float x = 0.9505f * fromLab(second[i] * (1.f / 500.f) + lightness);
    const float y = fromLab(lightness);
    const float z = 1.089f * fromLab(lightness - third[i] * (1.f / 200.f));
    const float r = withGamma(x * 3.2406f + y * -1.5372f + z * -0.4986f);
    const float g = withGamma(x * -0.9689f + y * 1.8758f + z * 0.0415f);
    const float b = withGamma(x * 0.0557f + y * -0.2040f + z * 1.0570f);
    const float greatest = std::max(std::max(r, g), std::max(b, 1.f));
    const float scale = 1.f / greatest;
    first[i] = std::max(r * scale, 0.f);
    second[i] = std::max(g * scale, 0.f);
    third[i] = std::max(b * scale, 0.f);
    const int brightest = greatest == 1.f ? 0 : greatest == r ? 1 : greatest == g ? 2 : 3;
    colors.branch[i] =
      static_cast<std::int32_t>(brightest * 8 + (r < 0.f ? 4 : 0) + (g < 0.f ? 2 : 0) + (b < 0.f ? 1 : 0));
  }
}

/// From hue, saturation and value, in place.
[[gnu::always_inline]] inline void hsvToRgb(ColorCurve::Colors& colors, std::size_t count)
{
  float* const first = colors.channel[0];
  float* const second = colors.channel[1];
  float* const third = colors.channel[2];
  for (std::size_t i = 0; i < count; ++i)
  {
    const float hue = 6.f * (first[i] < 0.f ? first[i] + 1.f : first[i]);
    const float saturation = second[i];
    const float value = third[i];
    const auto part = [&](float fromFull) {
      return value * (1.f - saturation * (1.f - std::clamp(2.f - fromFull, 0.f, 1.f)));
    };
    const float toEnd = std::min(hue, 6.f - hue);
    first[i] = part(toEnd);
    second[i] = part(std::abs(hue - 2.f));
    third[i] = part(std::abs(hue - 4.f));
    colors.branch[i] = static_cast<std::int32_t>(hue);
  }
}

/// From magnitude, saturation and hue of CIELAB's polar form to itself, in place.
[[gnu::always_inline]] inline void mshToLab(ColorCurve::Colors& colors, std::size_t count)
{
  constexpr float quarter = std::numbers::pi_v<float> / 2.f;
  float* const first = colors.channel[0];
  float* const second = colors.channel[1];
  float* const third = colors.channel[2];
  for (std::size_t i = 0; i < count; ++i)
  {
    const float magnitude = first[i];
    const float saturation = second[i];
    const float hue = third[i];
    const float chroma = magnitude * sine(saturation);
    first[i] = magnitude * sine(saturation + quarter);
    second[i] = chroma * sine(hue + quarter);
    third[i] = chroma * sine(hue);
  }
}

using Coordinates = std::array<double, 3>;

Coordinates toMsh(const double* rgb)
{
  double lab[3];
  vtkMath::RGBToLab(rgb, lab);
  constexpr double least = 0.001;
  const double magnitude = std::hypot(lab[0], lab[1], lab[2]);
  const double saturation = magnitude > least ? std::acos(lab[0] / magnitude) : 0.;
  return { magnitude, saturation, saturation > least ? std::atan2(lab[2], lab[1]) : 0. };
}

Coordinates coordinatesOf(ColorCurve::Space space, const Coordinates& rgb)
{
  Coordinates result = rgb;
  switch (space)
  {
    case ColorCurve::Space::Rgb:
      break;
    case ColorCurve::Space::Hsv:
    case ColorCurve::Space::WrappedHsv:
      vtkMath::RGBToHSV(rgb.data(), result.data());
      break;
    case ColorCurve::Space::Lab:
      vtkMath::RGBToLab(rgb.data(), result.data());
      break;
    case ColorCurve::Space::Diverging:
      result = toMsh(rgb.data());
      break;
  }
  return result;
}

constexpr double unsaturated = 0.05;

/// Gives a colour without saturation the hue from which the other one is reached.
void adjustHue(Coordinates& color, const Coordinates& other)
{
  if (!(color[1] < unsaturated && other[1] > unsaturated))
  {
    return;
  }
  color[2] = other[2];
  if (other[0] < color[0] - 0.1)
  {
    const double spin =
      other[1] * std::sqrt(color[0] * color[0] - other[0] * other[0]) / (other[0] * std::sin(other[1]));
    color[2] += other[2] > -0.3 * std::numbers::pi ? spin : -spin;
  }
}

} // namespace

ColorCurve::ColorCurve(const Ends& ends, const ColorCurve* before)
  : space_(ends.space)
  , isLogarithmic_(ends.isLogarithmic)
  , midpoint_(std::clamp(ends.a[4], 0.00001, 0.99999))
  , sharpness_(ends.a[5])
{
  const auto& [space, isLogarithmic, a, b] = ends;
  begin_ = isLogarithmic ? std::log(a[0]) : a[0];
  perWidth_ = 1. / ((isLogarithmic ? std::log(b[0]) : b[0]) - begin_);
  const Coordinates firstColor{ a[1], a[2], a[3] };
  lastColor_ = { b[1], b[2], b[3] };
  for (int c = 0; c < 3; ++c)
  {
    color_[0][c] = static_cast<float>(firstColor[c]);
    color_[1][c] = static_cast<float>(lastColor_[c]);
  }
  const bool isKnown = before && before->lastColor_ == firstColor;
  Coordinates first = isKnown ? before->lastCoordinates_ : coordinatesOf(space, firstColor);
  lastCoordinates_ = coordinatesOf(space, lastColor_);
  Coordinates last = lastCoordinates_;
  const auto set = [](Half& half, const Coordinates& from, const Coordinates& to) {
    for (int c = 0; c < 3; ++c)
    {
      half.first[c] = static_cast<float>(from[c]);
      half.change[c] = static_cast<float>(to[c] - from[c]);
    }
  };
  if (space == Space::WrappedHsv && std::abs(first[0] - last[0]) > 0.5)
  {
    (first[0] > last[0] ? first : last)[0] -= 1.;
  }
  if (space == Space::Diverging)
  {
    const double angle = std::abs(first[2] - last[2]);
    hasWhite_ = first[1] > unsaturated && last[1] > unsaturated &&
      std::min(angle, 2. * std::numbers::pi - angle) > 0.33 * std::numbers::pi;
    if (hasWhite_)
    {
      const Coordinates white{ std::max({ first[0], last[0], 88. }), 0., 0. };
      Coordinates below = white;
      Coordinates above = white;
      adjustHue(below, first);
      adjustHue(above, last);
      set(halves_[0], first, below);
      set(halves_[1], above, last);
    }
    else
    {
      adjustHue(first, last);
      adjustHue(last, first);
    }
  }
  if (!hasWhite_)
  {
    // Of the whole way in either half.
    set(halves_[0], first, last);
    halves_[1] = halves_[0];
  }
  const double middle = begin_ + midpoint_ / perWidth_;
  corner_ = isLogarithmic ? std::exp(middle) : middle;
}

[[gnu::always_inline]] inline void ColorCurve::findParts(
  const double* values, std::size_t count, float* parts) const
{
  for (std::size_t i = 0; i < count; ++i)
  {
    const double along = isLogarithmic_ ? std::log(values[i]) : values[i];
    const double part = std::clamp((along - begin_) * perWidth_, 0., 1.);
    parts[i] = static_cast<float>(
      part < midpoint_ ? 0.5 * part / midpoint_ : 0.5 + 0.5 * (part - midpoint_) / (1. - midpoint_));
  }
  if (sharpness_ < 0.01)
  {
    return;
  }
  for (std::size_t i = 0; i < count; ++i)
  {
    if (sharpness_ > 0.99)
    {
      parts[i] = parts[i] < 0.5f ? 0.f : 1.f;
      continue;
    }
    const double exponent = 1. + 10. * sharpness_;
    const double part = parts[i];
    const double s =
      part < 0.5 ? 0.5 * std::pow(2. * part, exponent) : 1. - 0.5 * std::pow(2. * (1. - part), exponent);
    // A cubic of the slope 1 - sharpness at both ends.
    const double straight = 1. - sharpness_;
    parts[i] = static_cast<float>(space_ == Space::Diverging
        ? s
        : s * (straight + s * 3. * (1. - straight) - s * s * 2. * (1. - straight)));
  }
}

[[gnu::always_inline]] inline void ColorCurve::compute(
  const double* values, std::size_t count, Colors& colors) const
{
  float parts[most];
  findParts(values, count, parts);
  // Whole vectors.
  constexpr std::size_t lanes = 8;
  for (; count % lanes != 0; ++count)
  {
    parts[count] = parts[count - 1];
  }
  if (sharpness_ > 0.99)
  {
    for (std::size_t i = 0; i < count; ++i)
    {
      const auto node = static_cast<std::size_t>(parts[i]);
      for (int c = 0; c < 3; ++c)
      {
        colors.channel[c][i] = color_[node][c];
      }
      colors.branch[i] = static_cast<std::int32_t>(node);
    }
    return;
  }
  for (int c = 0; c < 3; ++c)
  {
    const float first[2] = { halves_[0].first[c], halves_[1].first[c] };
    const float change[2] = { halves_[0].change[c], halves_[1].change[c] };
    const float scale = hasWhite_ ? 2.f : 1.f;
    const float shift = hasWhite_ ? 1.f : 0.f;
    float* const channel = colors.channel[c];
    for (std::size_t i = 0; i < count; ++i)
    {
      const bool isSecond = parts[i] >= 0.5f;
      channel[i] = isSecond ? first[1] + (scale * parts[i] - shift) * change[1]
                            : first[0] + scale * parts[i] * change[0];
    }
  }
  switch (space_)
  {
    case Space::Rgb:
      std::fill_n(colors.branch, count, std::int32_t(0));
      break;
    case Space::Hsv:
    case Space::WrappedHsv:
      hsvToRgb(colors, count);
      break;
    case Space::Diverging:
      mshToLab(colors, count);
      labToRgb(colors, count);
      break;
    case Space::Lab:
      labToRgb(colors, count);
      break;
  }
  if (sharpness_ >= 0.01)
  {
    for (float* const channel : { colors.channel[0], colors.channel[1], colors.channel[2] })
    {
      for (std::size_t i = 0; i < count; ++i)
      {
        channel[i] = std::clamp(channel[i], 0.f, 1.f);
      }
    }
  }
}

#ifdef __x86_64__
/// Without fused products: the same bits everywhere.
[[gnu::target("avx2")]] void ColorCurve::computeWithAvx2(
  const double* values, std::size_t count, Colors& colors) const
{
  compute(values, count, colors);
}
#endif

void ColorCurve::at(const double* values, std::size_t count, Colors& colors) const
{
#ifdef __x86_64__
  static const bool hasAvx2 = __builtin_cpu_supports("avx2");
  if (hasAvx2)
  {
    computeWithAvx2(values, count, colors);
    return;
  }
#endif
  compute(values, count, colors);
}

std::array<double, 3> ColorCurve::at(double value) const
{
  Colors colors;
  at(&value, 1, colors);
  return { colors.channel[0][0], colors.channel[1][0], colors.channel[2][0] };
}

} // namespace treeamr
