#include "Error.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <string>
#include <string_view>

namespace treeamr
{

namespace
{

/// Bytes of the character that a text begins with, 0 when it is none (RFC 3629).
std::size_t characterSize(std::string_view text)
{
  const auto first = static_cast<unsigned char>(text.front());
  const auto size = static_cast<std::size_t>(std::countl_one(first));
  if (size == 0)
  {
    return 1;
  }
  if (size == 1 || size > 4 || size > text.size())
  {
    return 0;
  }
  char32_t code = first & (0x7f >> size);
  for (const char next : text.substr(1, size - 1))
  {
    if ((next & 0xc0) != 0x80)
    {
      return 0;
    }
    code = code << 6 | (next & 0x3f);
  }
  constexpr char32_t least[] = { 0x80, 0x800, 0x10000 }; // of two, three, four bytes
  const bool isSurrogate = code >= 0xd800 && code < 0xe000;
  return code < least[size - 2] || isSurrogate || code > 0x10ffff ? 0 : size;
}

std::string readable(std::string text)
{
  for (std::size_t i = 0; i < text.size();)
  {
    const std::size_t size = characterSize(std::string_view(text).substr(i));
    if (size == 0)
    {
      text[i] = '?';
    }
    i += std::max<std::size_t>(size, 1);
  }
  return text;
}

} // namespace

Error::Error(const std::string& text)
  : std::runtime_error(readable(text))
{
}

} // namespace treeamr
