// A recursive-descent parser of
//   block = "skip" | "{" layout "}" | layout | ( "double" | "float" ) vector { "," vector } "=" element [ "corners" ]
//   vector = name [ "(" name { "," name } ")" ]
//   element = system | part { "-" part }
//   part = ( system | name dimension "(" degree ")" ) [ "^" number ]
//   system = "FESystem" dimension "[" part { "-" part } "]"
//   dimension = [ "<" "3" [ "," "3" ] ">" ]
#include "Forest/DealIIBlocks.h"

#include "Error.h"
#include "Forest/ElementMeans.h"
#include "Forest/TextTokens.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

namespace treeamr
{
namespace
{

constexpr std::size_t maxElements = 1000; // scalar ones in a system
constexpr std::size_t maxValues = 65536;  // of a cell in a block
constexpr int maxNesting = 8;             // of systems

/// At semicolons outside braces; the last may end the text.
std::vector<std::string_view> splitBlocks(std::string_view text)
{
  std::vector<std::string_view> blocks;
  text = trimmed(text);
  if (text.ends_with(';'))
  {
    text.remove_suffix(1);
  }
  bool inBraces = false;
  std::size_t first = 0;
  for (std::size_t i = 0; i <= text.size(); ++i)
  {
    if (i == text.size() || (text[i] == ';' && !inBraces))
    {
      blocks.push_back(trimmed(text.substr(first, i - first)));
      first = i + 1;
    }
    else if (text[i] == '{' || text[i] == '}')
    {
      inBraces = text[i] == '{';
    }
  }
  return blocks;
}

/// A part of a system: scalar elements side by side.
using Part = std::vector<ElementMean>;

class VectorsParser : TextTokens
{
public:
  using TextTokens::TextTokens;

  DealIIBlock parse()
  {
    if (token_ != "double" && token_ != "float")
    {
      fail("double or float, the type of a vector's values");
    }
    const PayloadType type = token_ == "double" ? PayloadType::Float64 : PayloadType::Float32;
    next();
    std::vector<Vector> vectors{ vector() };
    while (token_ == ",")
    {
      next();
      vectors.push_back(vector());
    }
    expect("=");
    const std::vector<Part> parts = element();
    const bool atCorners = token_ == "corners";
    if (atCorners)
    {
      checkCorners(parts);
      next();
    }
    if (!token_.empty())
    {
      fail("\"-\", \"^\", \"corners\", \";\" or the end");
    }

    std::size_t values = 0;
    for (const Part& part : parts)
    {
      values += countValues(part);
    }
    if (values * vectors.size() > maxValues)
    {
      failOfValues();
    }
    DealIIBlock block;
    for (const Vector& v : vectors)
    {
      addFields(v, parts, type, atCorners, block);
    }
    return block;
  }

private:
  static bool hasCorners(const Part& part)
  {
    // What an inner value adds everywhere is not in that of a vertex.
    return part.size() == 1 && part[0].vertex.size() == 1 && part[0].isInterpolated;
  }
  void checkCorners(const std::vector<Part>& parts) const
  {
    if (std::ranges::none_of(parts, hasCorners))
    {
      fail("corners for one component of FE_Q or FE_Q_iso_Q1 alone");
    }
  }

  struct Vector
  {
    std::string name;
    std::vector<std::string> parts;
  };

  std::string name()
  {
    if (!isName())
    {
      fail("a name");
    }
    std::string found(token_);
    next();
    return found;
  }

  Vector vector()
  {
    Vector found{ name(), {} };
    if (token_ == "(")
    {
      do
      {
        next();
        found.parts.push_back(name());
      }
      while (token_ == ",");
      expect(")");
    }
    return found;
  }

  /// The parts of the outermost system, be it written as one or not.
  std::vector<Part> element()
  {
    if (token_ == "FESystem")
    {
      const std::string_view start = token_;
      std::vector<Part> parts = system(0);
      if (token_ != "^" && token_ != "-")
      {
        return parts;
      }
      token_ = start; // one part of several
    }
    return partList(0);
  }

  std::vector<Part> system(int nesting)
  {
    if (nesting == maxNesting)
    {
      fail("at most " + std::to_string(maxNesting) + " systems in each other");
    }
    expect("FESystem");
    dimension();
    expect("[");
    std::vector<Part> parts = partList(nesting + 1);
    expect("]");
    return parts;
  }

  std::vector<Part> partList(int nesting)
  {
    std::vector<Part> parts{ part(nesting) };
    while (token_ == "-")
    {
      next();
      parts.push_back(part(nesting));
    }
    return parts;
  }

  Part part(int nesting)
  {
    Part once;
    if (token_ == "FESystem")
    {
      for (const Part& inner : system(nesting))
      {
        once.insert(once.end(), inner.begin(), inner.end());
      }
    }
    else
    {
      once.push_back(scalar());
    }
    Part all = once;
    if (token_ == "^")
    {
      next();
      const std::size_t mostTimes = std::min(maxElements / once.size(), maxValues / countValues(once));
      const int times = number(1, static_cast<int>(mostTimes));
      all.reserve(times * once.size());
      for (int i = 1; i < times; ++i)
      {
        all.insert(all.end(), once.begin(), once.end());
      }
    }
    // Inner ones are counted again with those around them.
    scalars_ += all.size();
    if (scalars_ > maxElements * (maxNesting + 2))
    {
      fail("at most " + std::to_string(maxElements) + " scalar elements");
    }
    values_ += countValues(all);
    if (values_ > maxValues * (maxNesting + 2))
    {
      failOfValues();
    }
    return all;
  }

  /// Of a cell.
  static std::size_t countValues(const Part& part)
  {
    std::size_t count = 0;
    for (const ElementMean& mean : part)
    {
      count += 8 * mean.vertex.size() + 12 * mean.line.size() + 6 * mean.quad.size() + mean.hex.size();
    }
    return count;
  }

  [[noreturn]] void failOfValues() const
  {
    fail("at most " + std::to_string(maxValues) + " values of a cell");
  }

  ElementMean scalar()
  {
    if (!elementMean(token_, 1))
    {
      fail("FESystem, " + elementNames() +
        ": leave out data of other elements by skip in place of the whole block");
    }
    const std::string_view found = token_;
    next();
    dimension();
    expect("(");
    const int least = elementMean(found, 0) ? 0 : 1;
    const ElementMean mean = *elementMean(found, number(least, maxElementDegree));
    expect(")");
    return mean;
  }

  void dimension()
  {
    if (token_ == "<")
    {
      next();
      expect("3");
      if (token_ == ",")
      {
        next();
        expect("3");
      }
      expect(">");
    }
  }

  /// Those of one vector, behind what the block has until now.
  void addFields(const Vector& vector, const std::vector<Part>& parts, PayloadType type, bool atCorners,
    DealIIBlock& block) const
  {
    if (!vector.parts.empty() && vector.parts.size() != parts.size())
    {
      throw Error("payload \"" + std::string(text_) + "\": " + std::to_string(vector.parts.size()) +
        " names in brackets, allowed " + std::to_string(parts.size()) +
        ", one for each part of the system that - joins");
    }
    const std::size_t first = block.fields.size();
    for (std::size_t p = 0; p < parts.size(); ++p)
    {
      const std::string name = !vector.parts.empty() ? vector.parts[p]
        : parts.size() == 1                          ? vector.name
                                                     : vector.name + '_' + std::to_string(p);
      const bool isAtCorners = atCorners && hasCorners(parts[p]);
      PayloadField field{ name, type, isAtCorners ? 8 : static_cast<int>(parts[p].size()), block.size };
      field.sums.resize(field.components);
      field.isAtCorners = isAtCorners;
      block.fields.push_back(std::move(field));
    }
    // A system has first what all of its elements have at the first vertex, and so on.
    std::uint32_t index = 0;
    for (const auto& [weights, count] :
      { std::pair(&ElementMean::vertex, 8), std::pair(&ElementMean::line, 12),
        std::pair(&ElementMean::quad, 6), std::pair(&ElementMean::hex, 1) })
    {
      for (int n = 0; n < count; ++n)
      {
        for (std::size_t p = 0; p < parts.size(); ++p)
        {
          for (std::size_t c = 0; c < parts[p].size(); ++c)
          {
            PayloadField& field = block.fields[first + p];
            for (const double weight : parts[p][c].*weights)
            {
              if (field.isAtCorners && count == 8)
              {
                field.sums[n].push_back({ index, 1. });
              }
              else if (!field.isAtCorners && weight != 0.)
              {
                field.sums[c].push_back({ index, weight });
              }
              ++index;
            }
          }
        }
      }
    }
    block.size += index * payloadTypeSize(type);
  }

  std::size_t scalars_ = 0;
  std::size_t values_ = 0;
};

DealIIBlock parseBlock(std::string_view text)
{
  DealIIBlock block;
  if (text == "skip")
  {
    block.skipped = true;
  }
  else if (text.find('=') != text.npos)
  {
    block = VectorsParser(text).parse();
  }
  else
  {
    std::string_view members = text;
    if (members.starts_with('{') && members.ends_with('}'))
    {
      members = members.substr(1, members.size() - 2);
    }
    const PayloadLayout layout = PayloadLayout::parse(members);
    if (layout.size() == 0)
    {
      throw Error("payload \"" + std::string(text) +
        "\": nothing for a block, allowed skip, vectors (\"double solution = FE_Q(1)\") or members of a "
        "struct");
    }
    block.size = layout.size();
    block.fields = layout.fields();
  }
  block.text = text;
  return block;
}

} // namespace

std::vector<DealIIBlock> parseDealIIBlocks(std::string_view text)
{
  std::vector<DealIIBlock> blocks;
  std::vector<std::string_view> names;
  const std::vector<std::string_view> pieces = splitBlocks(text);
  blocks.reserve(pieces.size()); // names are kept by reference
  for (const std::string_view piece : pieces)
  {
    for (const PayloadField& field : blocks.emplace_back(parseBlock(piece)).fields)
    {
      if (std::ranges::find(names, field.name) != names.end())
      {
        throw Error(
          "payload \"" + std::string(text) + "\": \"" + field.name + "\" twice, allowed names that differ");
      }
      names.push_back(field.name);
    }
  }
  return blocks;
}

} // namespace treeamr
