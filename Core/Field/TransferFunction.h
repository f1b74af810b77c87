// Colour and extinction over the field's value: tabulated, by nodes, or of categories.
#pragma once

#include "Field/Field.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace treeamr
{

/// Linear red, green, blue and extinction for each value; of values less the field's offset.
class TransferFunction
{
public:
  /// Of one value.
  struct Entry
  {
    ///@{
    /// Linear, 0 to 1, not premultiplied.
    float r, g, b;
    ///@}
    float extinction; // per unit of world length

    bool operator==(const Entry&) const = default;
  };
  /// entries: >= 2 samples equally spaced over [min, max], the ends included; linear in between, constant
  /// beyond. Where min == max, which is allowed, all values have the first entry. Throws Error for fewer entries, a
  /// non-finite or empty interval, negative or NaN extinction.
  TransferFunction(double min, double max, std::vector<Entry> entries);
  /// Where the function bends or jumps. Values below the node come to `below`, itself and those above it start from
  /// `above`.
  struct Node
  {
    double value; // where it is
    Entry below;  // what the function comes to
    Entry above;  // what it starts from
  };
  /// Linear from node to node, constant beyond the ends: `below` of the first, `above` of the last. nodes: one or
  /// more, values finite and increasing; throws Error for others, and for entries as above.
  static TransferFunction ofNodes(std::vector<Node> nodes);
  /// Categories: the leaf value i, a whole number, has entry i, and means nothing between two. So volumes show
  /// each leaf in its own value's entry, without reconstruction, whatever the settings. One entry or more, at most
  /// mostCategories; throws Error for others, and for entries as above.
  static TransferFunction ofCategories(std::vector<Entry> entries);
  /// Whole numbers that floats, the values of fields, can count.
  static constexpr std::size_t mostCategories = std::size_t(1) << 24;

  /// The same colours, of one extinction everywhere. Not for categories.
  TransferFunction withExtinction(float extinction) const;

  /// Opaque over any step, yet finite, so that interpolation beside it makes no NaN.
  static constexpr double opaqueExtinction = 1e30;
  /// Extinction per world length of a volume whose opacity over `unitDistance` is `opacity`.
  static float extinctionFromOpacity(double opacity, double unitDistance) noexcept;

  /// The value of the first entry or node.
  double min() const noexcept { return min_; }
  /// Entries per unit of value.
  double scale() const noexcept { return scale_; }
  /// Those of nodes are samples, which do not follow the function everywhere.
  const std::vector<Entry>& entries() const noexcept { return entries_; }
  /// Of a function of nodes; else empty.
  const std::vector<Node>& nodes() const noexcept { return nodes_; }
  /// Whether ofCategories() made it.
  bool hasCategories() const noexcept { return reach_ == 1; }

  /// Of a value in the table, 0 to entries - 1.
  double position(double value) const noexcept
  {
    const double p = (value - min_) * scale_;
    return p > 0. ? std::min(p, last_) : 0.;
  }
  /// Of a value: what is linear between entries or nodes, of categories the value's own.
  Entry at(float value) const noexcept;
  /// Of the entries.
  Entry atPosition(double position) const noexcept;
  /// Whether some value of the range has extinction: exact, so that skipping by it never changes a pixel.
  bool isVisible(Range range) const noexcept
  {
    if (!nodes_.empty())
    {
      return visibleBefore_[nodesUpTo(range.max) + 1] > visibleBefore_[nodesUpTo(range.min)];
    }
    // position() does not decrease, so every value of the range reads entries between these two.
    const std::size_t end = entries_.size() - reach_;
    const auto first = std::min(static_cast<std::size_t>(position(range.min)), end);
    const auto last = std::min(static_cast<std::size_t>(position(range.max)), end) + reach_ - 1;
    return visibleBefore_[last + 1] > visibleBefore_[first];
  }

  /// Exact at both ends, however opaque one is. part: 0 to 1.
  static Entry between(const Entry& a, const Entry& b, float part) noexcept;

private:
  TransferFunction() = default;

  /// How many nodes are at the value or below it.
  std::size_t nodesUpTo(double value) const noexcept
  {
    const auto entry = static_cast<std::size_t>(position(value));
    const auto begin = nodes_.begin();
    return static_cast<std::size_t>(
      std::upper_bound(begin + nodesBefore_[entry], begin + nodesBefore_[entry + 1], value,
        [](double v, const Node& node) { return v < node.value; }) -
      begin);
  }
  Entry atValue(double value) const noexcept;

  double min_; // double: values up to 1e38 have differences beyond float
  double scale_;
  double last_;
  std::vector<Entry> entries_;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> nodesBefore_; // that may be searched from the i-th entry's place on
  /// Entries, or parts between nodes, with extinction among the first i.
  std::vector<std::uint32_t> visibleBefore_;
  std::size_t reach_ = 2; // entries that one value reads: of a category its own alone
};

} // namespace treeamr
