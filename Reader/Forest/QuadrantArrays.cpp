#include "Forest/QuadrantArrays.h"

#include "Error.h"
#include "Forest/P4estInputFile.h"
#include "Forest/TextTokens.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <utility>

namespace treeamr
{

namespace
{

[[noreturn]] void failOfText(std::string_view item, const std::string& found, const std::string& allowed)
{
  throw Error("quadrant arrays, \"" + std::string(item) + "\": " + found + ", allowed " + allowed);
}

QuadrantArray parseItem(std::string_view item)
{
  const std::size_t equals = item.find('=');
  const std::string_view path = trimmed(equals == item.npos ? item : item.substr(equals + 1));
  const std::string_view declaration =
    equals == item.npos ? std::string_view() : trimmed(item.substr(0, equals));
  if (path.empty())
  {
    failOfText(item, "no file", "name = file.npy, or type name[n] = file");
  }
  QuadrantArray array{ {}, path.ends_with(".npy"), std::string(path) };
  if (array.isNumpy)
  {
    const bool isName = declaration.find_first_of(" \t[]") == declaration.npos;
    if (!isName)
    {
      failOfText(item, "\"" + std::string(declaration) + "\" for a file that says its type", "a name alone");
    }
    array.field.name =
      declaration.empty() ? std::filesystem::path(path).stem().string() : std::string(declaration);
    return array;
  }
  if (declaration.empty())
  {
    failOfText(item, "a file that does not say its type", "type name[n] = file, for files other than .npy");
  }
  const PayloadLayout layout = PayloadLayout::parse(declaration);
  if (layout.fields().size() != 1)
  {
    failOfText(item, std::to_string(layout.fields().size()) + " arrays in one file", "one");
  }
  array.field = layout.fields().front();
  array.field.offset = 0;
  return array;
}

/// The header of one of numpy's files: what its dictionary says, and where the values begin.
class NumpyHeader
{
public:
  explicit NumpyHeader(P4estInputFile& file)
    : file_(file)
  {
    constexpr std::array<unsigned char, 6> magic{ 0x93, 'N', 'U', 'M', 'P', 'Y' };
    std::array<unsigned char, 8> begin{}; // and the version
    if (file.size() >= begin.size())
    {
      file.read(begin.data(), begin.size(), "header");
    }
    if (!std::equal(magic.begin(), magic.end(), begin.begin()))
    {
      file.fail("no magic string of numpy's, allowed a file of numpy.save");
    }
    std::array<unsigned char, 4> length{};
    const std::size_t lengthBytes = begin[6] == 1 ? 2 : 4;
    if (begin[6] < 1 || begin[6] > 3 || file.size() < begin.size() + lengthBytes)
    {
      file.fail("format version ", int(begin[6]), ", allowed 1 to 3");
    }
    file.read(length.data(), lengthBytes, "header");
    const std::uint64_t size = length[0] | length[1] << 8 | length[2] << 16 | std::uint64_t(length[3]) << 24;
    if (size > file.size() - file.position())
    {
      file.fail("a header of ", size, " bytes, allowed what the file's ", file.size(), " bytes hold");
    }
    text_.resize(size);
    file.read(text_.data(), size, "header");
  }

  PayloadType type() const
  {
    const std::string_view value = this->valueOf("descr");
    const std::string_view name = value.size() > 2 && (value[0] == '\'' || value[0] == '"')
      ? value.substr(1, value.find(value[0], 1) - 1)
      : value;
    constexpr auto types = std::to_array<std::pair<std::string_view, PayloadType>>(
      { { "b1", PayloadType::UInt8 }, { "i1", PayloadType::Int8 }, { "u1", PayloadType::UInt8 },
        { "i2", PayloadType::Int16 }, { "u2", PayloadType::UInt16 }, { "i4", PayloadType::Int32 },
        { "u4", PayloadType::UInt32 }, { "i8", PayloadType::Int64 }, { "u8", PayloadType::UInt64 },
        { "f4", PayloadType::Float32 }, { "f8", PayloadType::Float64 } });
    const bool hasOrder = name.size() == 3 && (name[0] == '<' || name[0] == '|' || name[0] == '=');
    const auto found = std::ranges::find(
      types, hasOrder ? name.substr(1) : name, &std::pair<std::string_view, PayloadType>::first);
    if (found == types.end())
    {
      file_.fail("type ", name, ", allowed little-endian floats of 4 and 8 bytes and integers");
    }
    return found->second;
  }

  bool isOfFortran() const { return this->valueOf("fortran_order").starts_with("True"); }

  /// Of each axis.
  std::vector<std::uint64_t> shape() const
  {
    const std::string_view value = this->valueOf("shape");
    const std::size_t end = value.find(')');
    std::vector<std::uint64_t> shape;
    if (!value.starts_with('(') || end == value.npos)
    {
      file_.fail("no shape in its header, allowed a file of numpy.save");
    }
    for (std::size_t at = 1; at < end;)
    {
      const std::size_t comma = std::min(value.find(',', at), end);
      const std::string_view number = trimmed(value.substr(at, comma - at));
      std::uint64_t axis = 0;
      const auto [rest, code] = std::from_chars(number.data(), number.data() + number.size(), axis);
      if (!number.empty() && (code != std::errc() || rest != number.data() + number.size()))
      {
        file_.fail("shape ", value.substr(0, end + 1), ", allowed whole numbers");
      }
      if (!number.empty())
      {
        shape.push_back(axis);
      }
      at = comma + 1;
    }
    return shape;
  }

private:
  /// What follows a key of the dictionary.
  std::string_view valueOf(std::string_view key) const
  {
    const std::string_view text = text_;
    for (const char quote : { '\'', '"' })
    {
      const std::size_t at = text.find(quote + std::string(key) + quote);
      const std::size_t colon = at == text.npos ? at : text.find(':', at);
      if (colon != text.npos)
      {
        return trimmed(text.substr(colon + 1));
      }
    }
    file_.fail("no ", key, " in its header, allowed a file of numpy.save");
  }

  const P4estInputFile& file_;
  std::string text_;
};

std::string resolved(const std::string& path, const std::string& forestPath)
{
  const std::filesystem::path forest(forestPath);
  std::string text = path;
  const std::string stem = forest.stem().string();
  for (std::size_t at = text.find("{}"); at != text.npos; at = text.find("{}", at + stem.size()))
  {
    text.replace(at, 2, stem);
  }
  return (forest.parent_path() / text).string();
}

} // namespace

std::vector<QuadrantArray> parseQuadrantArrays(std::string_view text)
{
  std::vector<QuadrantArray> arrays;
  for (std::size_t at = 0; at <= text.size();)
  {
    const std::size_t end = std::min(text.find(';', at), text.size());
    const std::string_view item = trimmed(text.substr(at, end - at));
    at = end + 1;
    if (item.empty())
    {
      continue;
    }
    QuadrantArray array = parseItem(item);
    if (std::ranges::any_of(arrays, [&](const QuadrantArray& a) { return a.field.name == array.field.name; }))
    {
      failOfText(item, "a name that is there already", "each name once");
    }
    arrays.push_back(std::move(array));
  }
  return arrays;
}

QuadrantArrayFile::QuadrantArrayFile(
  const QuadrantArray& array, const std::string& forestPath, std::uint64_t quadrants)
  : field_(array.field)
{
  const std::string path = resolved(array.path, forestPath);
  P4estInputFile file(path, "a file of values");
  const std::string allowed = std::to_string(quadrants) + ", one for each quadrant of " + forestPath;
  if (array.isNumpy)
  {
    const NumpyHeader header(file);
    field_.type = header.type();
    const std::vector<std::uint64_t> shape = header.shape();
    constexpr std::uint64_t mostComponents = 1 << 16;
    if (shape.empty() || shape.size() > 2 || shape[0] != quadrants ||
      (shape.size() == 2 && (shape[1] == 0 || shape[1] > mostComponents)))
    {
      std::string found;
      for (const std::uint64_t axis : shape)
      {
        found += (found.empty() ? "" : ", ") + std::to_string(axis);
      }
      file.fail(
        "shape (", found, "), allowed a first axis of ", allowed, ", and perhaps a second one of components");
    }
    field_.components = shape.size() == 2 ? static_cast<int>(shape[1]) : 1;
    if (header.isOfFortran() && field_.components > 1)
    {
      file.fail("values in Fortran order, allowed C order (numpy.ascontiguousarray)");
    }
  }
  const std::size_t recordBytes = payloadTypeSize(field_.type) * static_cast<std::size_t>(field_.components);
  const std::uint64_t bytes = file.size() - file.position();
  if (bytes / recordBytes != quadrants || bytes % recordBytes != 0)
  {
    file.fail(bytes, " bytes of values, ", recordBytes, " each, allowed ", allowed);
  }
  records_.emplace(path, file.position(), recordBytes);
}

} // namespace treeamr
