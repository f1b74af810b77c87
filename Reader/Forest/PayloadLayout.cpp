// A recursive-descent parser of
//   layout = [ "packed" ] [ member { ";" member } [ ";" ] ]
//   member = "pad" "[" number "]" | type declarator { "," declarator }
//   declarator = name [ "[" number "]" ]
#include "Forest/PayloadLayout.h"

#include "Error.h"
#include "Forest/TextTokens.h"

#include <algorithm>
#include <array>
#include <utility>

namespace treeamr
{
namespace
{

constexpr std::size_t maxPayloadBytes = std::size_t(1) << 30;

struct TypeName
{
  std::string_view name;
  PayloadType type;
};

/// Words are joined by single spaces; with a trailing _t the sized names are C's own.
constexpr auto typeNames = std::to_array<TypeName>({
  { "char", PayloadType::Int8 },
  { "signed char", PayloadType::Int8 },
  { "int8", PayloadType::Int8 },
  { "unsigned char", PayloadType::UInt8 },
  { "uint8", PayloadType::UInt8 },
  { "short", PayloadType::Int16 },
  { "short int", PayloadType::Int16 },
  { "int16", PayloadType::Int16 },
  { "unsigned short", PayloadType::UInt16 },
  { "unsigned short int", PayloadType::UInt16 },
  { "uint16", PayloadType::UInt16 },
  { "int", PayloadType::Int32 },
  { "signed", PayloadType::Int32 },
  { "signed int", PayloadType::Int32 },
  { "int32", PayloadType::Int32 },
  { "unsigned", PayloadType::UInt32 },
  { "unsigned int", PayloadType::UInt32 },
  { "uint32", PayloadType::UInt32 },
  { "long", PayloadType::Int64 },
  { "long int", PayloadType::Int64 },
  { "long long", PayloadType::Int64 },
  { "long long int", PayloadType::Int64 },
  { "int64", PayloadType::Int64 },
  { "unsigned long", PayloadType::UInt64 },
  { "unsigned long int", PayloadType::UInt64 },
  { "unsigned long long", PayloadType::UInt64 },
  { "unsigned long long int", PayloadType::UInt64 },
  { "uint64", PayloadType::UInt64 },
  { "float", PayloadType::Float32 },
  { "double", PayloadType::Float64 },
});

const TypeName* findType(std::string_view name)
{
  if (name.ends_with("_t") && name.find("int") != name.npos)
  {
    name.remove_suffix(2);
    if (name.back() < '0' || name.back() > '9')
    {
      return nullptr;
    }
  }
  const auto found = std::ranges::find(typeNames, name, &TypeName::name);
  return found == typeNames.end() ? nullptr : &*found;
}

} // namespace

std::size_t payloadTypeSize(PayloadType type) noexcept
{
  constexpr std::array<std::size_t, 10> sizes = { 1, 1, 2, 2, 4, 4, 8, 8, 4, 8 };
  static_assert(static_cast<std::size_t>(PayloadType::Float64) + 1 == sizes.size());
  return sizes[static_cast<std::size_t>(type)];
}

class PayloadParser : TextTokens
{
public:
  using TextTokens::TextTokens;

  PayloadLayout parse()
  {
    if (token_ == "packed")
    {
      packed_ = true;
      next();
    }
    while (!token_.empty())
    {
      member();
      if (token_ == ";")
      {
        next();
      }
      else if (!token_.empty())
      {
        fail("\",\", \";\" or the end");
      }
    }
    pad((alignment_ - layout_.size_ % alignment_) % alignment_);
    return std::move(layout_);
  }

private:
  void member()
  {
    if (token_ == "pad")
    {
      next();
      if (token_ != "[")
      {
        fail("\"[\" and a number of bytes");
      }
      pad(static_cast<std::size_t>(arrayLength()));
      return;
    }
    const PayloadType type = parseType();
    declarator(type);
    while (token_ == ",")
    {
      next();
      declarator(type);
    }
  }

  /// The longest run of words that is a type: a word after it is the name.
  PayloadType parseType()
  {
    std::string name(token_);
    const TypeName* found = findType(name);
    while (true)
    {
      if (!found)
      {
        fail("pad[n] or a type: char, int8, uint8, ..., int64, uint64, float, double");
      }
      next();
      const TypeName* const longer = findType(name += ' ' + std::string(token_));
      if (!longer)
      {
        return found->type;
      }
      found = longer;
    }
  }

  void declarator(PayloadType type)
  {
    if (!isName() || token_ == "pad" || findType(token_))
    {
      fail("a name");
    }
    if (std::ranges::any_of(layout_.fields_, [&](const PayloadField& field) { return field.name == token_; }))
    {
      fail("a name that is not there yet");
    }
    PayloadField field{ std::string(token_), type, 1, 0 };
    next();
    if (token_ == "[")
    {
      field.components = arrayLength();
    }
    const std::size_t size = payloadTypeSize(type);
    const std::size_t alignment = packed_ ? 1 : size;
    alignment_ = std::max(alignment_, alignment);
    pad((alignment - layout_.size_ % alignment) % alignment);
    field.offset = layout_.size_;
    pad(size * static_cast<std::size_t>(field.components));
    layout_.fields_.push_back(std::move(field));
  }

  /// From "[" to behind "]".
  int arrayLength()
  {
    next();
    const int length = number(1, static_cast<int>(maxPayloadBytes));
    expect("]");
    return length;
  }

  void pad(std::size_t bytes)
  {
    layout_.size_ += bytes;
    if (layout_.size_ > maxPayloadBytes)
    {
      fail("at most " + std::to_string(maxPayloadBytes) + " bytes in all");
    }
  }

  bool packed_ = false;       // members begin where the ones before end
  std::size_t alignment_ = 1; // of the whole
  PayloadLayout layout_;
};

PayloadLayout PayloadLayout::parse(std::string_view text)
{
  return PayloadParser(text).parse();
}

} // namespace treeamr
