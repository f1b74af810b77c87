// A fuzz target without libFuzzer: plays all files of the corpora, then inputs made from them, the same ones in each run.
//
// <target> [-runs=COUNT] FOLDER...
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv);
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace
{

using Input = std::string;

class Mutations
{
public:
  explicit Mutations(const std::vector<Input>& corpus)
    : corpus_(corpus)
  {
  }

  Input next()
  {
    Input input = corpus_[below(corpus_.size())];
    for (std::size_t i = 1 + below(4); i > 0 && !input.empty(); --i)
    {
      change(input);
    }
    return input;
  }

private:
  std::size_t below(std::size_t end)
  {
    return std::uniform_int_distribution<std::size_t>(0, end - 1)(random_);
  }
  Input::iterator somewhere(Input& input)
  {
    return input.begin() + static_cast<std::ptrdiff_t>(below(input.size()));
  }

  void change(Input& input)
  {
    switch (below(6))
    {
      case 0:
        *somewhere(input) ^= static_cast<char>(1u << below(8));
        break;
      case 1:
        *somewhere(input) = static_cast<char>(below(256));
        break;
      case 2: // a number at the end of some type's range, or small
      {
        const std::int64_t numbers[] = { 0, 1, -1, 7, 1 << 30, INT32_MAX, INT32_MIN, INT64_MAX, INT64_MIN };
        const std::int64_t number = numbers[below(std::size(numbers))];
        const auto at = somewhere(input);
        const std::size_t room = std::min<std::size_t>(input.end() - at, std::size_t(1) << below(4));
        std::copy_n(reinterpret_cast<const char*>(&number), room, at);
        break;
      }
      case 3:
        input.erase(somewhere(input), input.end());
        break;
      case 4: // a part goes elsewhere
      {
        const std::size_t from = below(input.size());
        const Input part = input.substr(from, 1 + below(input.size() - from));
        const std::size_t to = below(input.size());
        input.replace(to, part.size(), part, 0, input.size() - to);
        break;
      }
      default: // the end of another one
      {
        const Input& other = corpus_[below(corpus_.size())];
        const std::size_t at = below(input.size());
        input.replace(at, Input::npos, other, std::min(at, other.size()));
      }
    }
  }

  const std::vector<Input>& corpus_;
  std::mt19937_64 random_{ 1 };
};

} // namespace

int main(int argc, char** argv)
try
{
  LLVMFuzzerInitialize(&argc, &argv);
  std::vector<Input> corpus;
  long runs = 0;
  for (int i = 1; i < argc; ++i)
  {
    const std::string argument = argv[i];
    if (argument.starts_with("-runs="))
    {
      runs = std::stol(argument.substr(6));
      continue;
    }
    for (const auto& entry : std::filesystem::directory_iterator(argument))
    {
      std::ifstream file(entry.path(), std::ios::binary);
      corpus.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    }
  }
  std::sort(corpus.begin(), corpus.end()); // whatever the folder's order
  if (corpus.empty())
  {
    std::fprintf(stderr, "no corpus: %s [-runs=COUNT] FOLDER...\n", argv[0]);
    return EXIT_FAILURE;
  }
  const auto play = [](const Input& input) {
    // A copy of the input's size, whose ends a sanitizer watches.
    const std::vector<std::uint8_t> bytes(input.begin(), input.end());
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  };
  std::for_each(corpus.begin(), corpus.end(), play);
  Mutations mutations(corpus);
  for (long i = 0; i < runs; ++i)
  {
    play(mutations.next());
  }
  std::printf("%zu files, %ld inputs made from them\n", corpus.size(), runs);
  return EXIT_SUCCESS;
}
catch (const std::exception& e)
{
  std::fprintf(stderr, "%s\n", e.what());
  return EXIT_FAILURE;
}
