// The fewest lines of colour and extinction that follow a colour curve over a line of opacities. Private to the module.
#pragma once

#include "ColorCurve.h"
#include "Field/TransferFunction.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace treeamr
{

/// From value to value, colours and extinctions linear in between.
struct LinePiece
{
  float begin;
  float end;
  TransferFunction::Entry atBegin;
  TransferFunction::Entry atEnd;
};

/// A part of a curve and the line of opacities over it. Values: less the offset, which the curve's are not.
struct ColorPart
{
  ColorCurve::Ends curve;
  double begin;
  double end;
  double opacityAtBegin; // 0 to 1
  double opacityAtEnd;
  double offset;
  double unitDistance;
};

class LinePieces
{
public:
  /// extinctionPart: by how much of itself a faint extinction may err.
  explicit LinePieces(double extinctionPart)
    : extinctionPart_(static_cast<float>(extinctionPart))
  {
  }

  /// Pieces that follow a part to colorsOfMany of a channel: colours, and what one line a piece shows of them in a table
  /// of many nodes. They begin and end at floats; colours may jump a little from one to the next, extinctions do not.
  /// None where single precision and samples do not tell all of it.
  const std::vector<LinePiece>& follow(const ColorPart& part);
  /// Of the part followed last, where it begins and ends.
  TransferFunction::Entry first() const { return entryOf(samples_.front()); }
  TransferFunction::Entry last() const { return entryOf(samples_.back()); }

private:
  static bool canFollow(const ColorCurve& curve, const ColorPart& part);

  struct Sample
  {
    /// The fourth is none: vectors have four.
    std::array<float, 4> color;
    float place;      // 0 to 1 in the part
    float extinction; // over the unit distance
    float perError;   // 1 / what this may be off by
    std::int32_t branch;
  };
  /// A gap in which the branch changes.
  struct Corner
  {
    float place;
    float width;
    std::int32_t branch;
  };
  /// A line from sample to sample.
  struct Fit
  {
    bool isClose;
    /// How far its colours are off to either side, or its extinctions, of what they may be; at least, where that is more
    /// than 1.
    float ofAllowed;
    /// What it may be moved by, so that it errs to either side alike.
    std::array<float, 4> shift;
  };

  void sample(const ColorCurve& curve, const ColorPart& part);
  void wantExtinctions(const ColorPart& part);
  void addSamples(const ColorCurve& curve, const ColorPart& part);
  bool findCorners(const ColorCurve& curve, const ColorPart& part);
  static void narrowDown(
    const ColorCurve& curve, const ColorPart& part, std::span<Corner> corners, std::size_t parts);
  bool divideGaps();
  void divideGap(std::size_t gap, float error);
  Sample at(std::size_t step) const;
  Fit fit(const Sample& a, std::size_t first, std::size_t last) const;
  std::size_t longest(std::size_t first, std::size_t expected, Fit& fitted) const;
  TransferFunction::Entry entryOf(const Sample& sample, const std::array<float, 4>& shift = {}) const;

  float extinctionPart_;
  std::optional<ColorCurve> curve_; // of the part
  double unitDistance_ = 1.;
  float corner_ = 0.f;          // place of the curve's own
  std::vector<Sample> samples_; // in order of their places
  std::vector<float> bends_;    // at samples: by how much slopes change per place, halved
  std::vector<Corner> corners_;
  std::vector<float> wanted_; // places of more samples, in order
  std::vector<LinePiece> pieces_;
};

/// The pieces of many parts, in their order.
class FollowedParts
{
public:
  FollowedParts() = default;
  /// In parallel.
  FollowedParts(const std::vector<ColorPart>& parts, double extinctionPart);

  struct Part
  {
    std::size_t begin = 0; // of its pieces among those of its block
    std::size_t end = 0;
    TransferFunction::Entry first{}; // where the part begins
    TransferFunction::Entry last{};
  };
  const Part& operator[](std::size_t i) const { return parts_[i]; }
  std::span<const LinePiece> piecesOf(std::size_t i) const
  {
    return std::span(blocks_[i / partsOfBlock]).subspan(parts_[i].begin, parts_[i].end - parts_[i].begin);
  }

private:
  static constexpr std::size_t partsOfBlock = 32;

  std::vector<Part> parts_;
  std::vector<std::vector<LinePiece>> blocks_;
};

} // namespace treeamr
