// The tokens of a text that tells what a cell's bytes are, with errors that say where in it. Private to the parsers.
#pragma once

#include "Error.h"

#include <charconv>
#include <cstddef>
#include <string>
#include <string_view>

namespace treeamr
{

/// Without the blanks around it.
inline std::string_view trimmed(std::string_view text)
{
  constexpr std::string_view blanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(blanks);
  return first == text.npos ? std::string_view()
                            : text.substr(first, text.find_last_not_of(blanks) + 1 - first);
}

class TextTokens
{
public:
  /// Kept by reference.
  explicit TextTokens(std::string_view text)
    : text_(text)
  {
    next();
  }

protected:
  static constexpr bool isWordCharacter(char c)
  {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  }
  static constexpr bool isDigit(char c) { return c >= '0' && c <= '9'; }

  [[noreturn]] void fail(const std::string& allowed) const
  {
    const auto position = static_cast<std::size_t>(token_.data() - text_.data()) + 1;
    throw Error("payload \"" + std::string(text_) + "\", position " + std::to_string(position) + ": " +
      (token_.empty() ? "the end" : "\"" + std::string(token_) + "\"") + ", allowed " + allowed);
  }

  /// The next token: a word of letters, digits and underscores, or any single other character.
  void next()
  {
    const char* at = token_.data() ? token_.data() + token_.size() : text_.data();
    const char* const end = text_.data() + text_.size();
    while (at != end && (*at == ' ' || *at == '\t' || *at == '\n' || *at == '\r'))
    {
      ++at;
    }
    const char* tokenEnd = at;
    while (tokenEnd != end && isWordCharacter(*tokenEnd))
    {
      ++tokenEnd;
    }
    if (tokenEnd == at && at != end)
    {
      ++tokenEnd;
    }
    token_ = std::string_view(at, static_cast<std::size_t>(tokenEnd - at));
  }

  /// Goes past a token that must be there.
  void expect(std::string_view token)
  {
    if (token_ != token)
    {
      fail('"' + std::string(token) + '"');
    }
    next();
  }

  bool isName() const { return !token_.empty() && isWordCharacter(token_[0]) && !isDigit(token_[0]); }

  /// Goes past a number in [min, max].
  int number(int min, int max)
  {
    int value = 0;
    const auto [end, code] = std::from_chars(token_.data(), token_.data() + token_.size(), value);
    if (code != std::errc() || end != token_.data() + token_.size() || value < min || value > max)
    {
      fail("a number in " + std::to_string(min) + ".." + std::to_string(max));
    }
    next();
    return value;
  }

  std::string_view text_;
  std::string_view token_; // a part of text_, empty at its end
};

} // namespace treeamr
