// Payload layouts against what the compiler makes of the same struct, and the errors of bad texts.
#include "Forest/PayloadLayout.h"
#include "Error.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <tuple>

using namespace treeamr;

namespace
{

struct Expected
{
  std::string name;
  PayloadType type;
  int components;
  std::size_t offset;
};

void expectLayout(const std::string& text, std::size_t size, const std::vector<Expected>& fields)
{
  const PayloadLayout layout = PayloadLayout::parse(text);
  EXPECT_EQ(layout.size(), size) << text;
  ASSERT_EQ(layout.fields().size(), fields.size()) << text;
  for (std::size_t i = 0; i < fields.size(); ++i)
  {
    EXPECT_EQ(layout.fields()[i].name, fields[i].name) << text;
    EXPECT_EQ(layout.fields()[i].type, fields[i].type) << text << ", " << fields[i].name;
    EXPECT_EQ(layout.fields()[i].components, fields[i].components) << text << ", " << fields[i].name;
    EXPECT_EQ(layout.fields()[i].offset, fields[i].offset) << text << ", " << fields[i].name;
  }
}

void expectError(
  const std::string& text, std::size_t position, const std::string& found, const std::string& allowed)
{
  try
  {
    PayloadLayout::parse(text);
    FAIL() << "no error in " << text;
  }
  catch (const Error& error)
  {
    const std::string message = error.what();
    const std::string begin =
      "payload \"" + text + "\", position " + std::to_string(position) + ": " + found + ", allowed ";
    EXPECT_EQ(message.substr(0, begin.size()), begin);
    EXPECT_NE(message.find(allowed, begin.size()), std::string::npos) << message;
  }
}

TEST(PayloadLayoutTest, OneValue)
{
  expectLayout("double value", 8, { { "value", PayloadType::Float64, 1, 0 } });
  expectLayout("  double\tvalue ;\n", 8, { { "value", PayloadType::Float64, 1, 0 } });
  expectLayout("double velocity[3];", 24, { { "velocity", PayloadType::Float64, 3, 0 } });
  expectLayout("float v [ 2 ]", 8, { { "v", PayloadType::Float32, 2, 0 } });
}

TEST(PayloadLayoutTest, LaidOutAsTheCompilerDoes)
{
  struct S
  {
    double rho;
    double velocity[3];
    int rank, flags;
    char mark;
  };
  expectLayout("double rho; double velocity[3]; int rank, flags; char mark", sizeof(S),
    { { "rho", PayloadType::Float64, 1, offsetof(S, rho) },
      { "velocity", PayloadType::Float64, 3, offsetof(S, velocity) },
      { "rank", PayloadType::Int32, 1, offsetof(S, rank) },
      { "flags", PayloadType::Int32, 1, offsetof(S, flags) },
      { "mark", PayloadType::Int8, 1, offsetof(S, mark) } });

  struct T
  {
    char a;
    short b[3];
    char c[5];
    float d;
    unsigned char e;
    long long f;
    unsigned short g;
  };
  expectLayout("char a; short b[3]; char c[5]; float d; unsigned char e; long long f; unsigned short g",
    sizeof(T),
    { { "a", PayloadType::Int8, 1, offsetof(T, a) }, { "b", PayloadType::Int16, 3, offsetof(T, b) },
      { "c", PayloadType::Int8, 5, offsetof(T, c) }, { "d", PayloadType::Float32, 1, offsetof(T, d) },
      { "e", PayloadType::UInt8, 1, offsetof(T, e) }, { "f", PayloadType::Int64, 1, offsetof(T, f) },
      { "g", PayloadType::UInt16, 1, offsetof(T, g) } });
}

TEST(PayloadLayoutTest, EveryNameOfAType)
{
  const std::vector<std::tuple<PayloadType, std::size_t, std::vector<std::string>>> types = {
    { PayloadType::Int8, 1, { "char", "signed char", "int8", "int8_t" } },
    { PayloadType::UInt8, 1, { "unsigned char", "uint8", "uint8_t" } },
    { PayloadType::Int16, 2, { "short", "short int", "int16", "int16_t" } },
    { PayloadType::UInt16, 2, { "unsigned short", "unsigned short int", "uint16", "uint16_t" } },
    { PayloadType::Int32, 4, { "int", "signed", "signed int", "int32", "int32_t" } },
    { PayloadType::UInt32, 4, { "unsigned", "unsigned int", "uint32", "uint32_t" } },
    { PayloadType::Int64, 8, { "long", "long int", "long long", "long long int", "int64", "int64_t" } },
    { PayloadType::UInt64, 8,
      { "unsigned long", "unsigned long int", "unsigned long long", "unsigned  long  long  int", "uint64",
        "uint64_t" } },
    { PayloadType::Float32, 4, { "float" } },
    { PayloadType::Float64, 8, { "double" } },
  };
  for (const auto& [type, size, names] : types)
  {
    EXPECT_EQ(payloadTypeSize(type), size);
    for (const std::string& name : names)
    {
      // One byte before: the alignment is the type's size.
      expectLayout("pad[1]; " + name + " x[3]", 4 * size, { { "x", type, 3, size } });
    }
  }
}

TEST(PayloadLayoutTest, Padding)
{
  expectLayout("pad[4]; float x; pad[5]", 16, { { "x", PayloadType::Float32, 1, 4 } });
  expectLayout("pad[4]; double x", 16, { { "x", PayloadType::Float64, 1, 8 } });
  expectLayout("pad[12]", 12, {});
  expectLayout("", 0, {});
}

TEST(PayloadLayoutTest, PackedAsTheCompilerDoes)
{
  struct __attribute__((packed)) S
  {
    char kind;
    double rho;
    short counts[3];
    long id;
    char mark;
  };
  expectLayout("packed char kind; double rho; short counts[3]; long id; char mark", sizeof(S),
    { { "kind", PayloadType::Int8, 1, offsetof(S, kind) },
      { "rho", PayloadType::Float64, 1, offsetof(S, rho) },
      { "counts", PayloadType::Int16, 3, offsetof(S, counts) },
      { "id", PayloadType::Int64, 1, offsetof(S, id) },
      { "mark", PayloadType::Int8, 1, offsetof(S, mark) } });
  expectLayout("packed", 0, {});
  expectLayout("packed pad[3]; int i", 7, { { "i", PayloadType::Int32, 1, 3 } });
  expectLayout("int packed", 4, { { "packed", PayloadType::Int32, 1, 0 } });
  expectError("packed; int i", 7, "\";\"", "pad[n] or a type: char, ");
  expectError("int i; packed double x", 8, "\"packed\"", "pad[n] or a type: char, ");
}

TEST(PayloadLayoutTest, NamesThatLookLikeTypes)
{
  expectLayout("int integer, int_, pads, point_t; float Double", 20,
    { { "integer", PayloadType::Int32, 1, 0 }, { "int_", PayloadType::Int32, 1, 4 },
      { "pads", PayloadType::Int32, 1, 8 }, { "point_t", PayloadType::Int32, 1, 12 },
      { "Double", PayloadType::Float32, 1, 16 } });
}

TEST(PayloadLayoutTest, Errors)
{
  expectError("rho", 1, "\"rho\"", "pad[n] or a type: char, ");
  expectError("double rho; dooble v", 13, "\"dooble\"", "pad[n] or a type: char, ");
  expectError("double rho; ; int i", 13, "\";\"", "pad[n] or a type: char, ");
  expectError("long double x", 6, "\"double\"", "a name");
  expectError("int64_x a", 1, "\"int64_x\"", "a type");
  expectError("point_t a", 1, "\"point_t\"", "a type");
  expectError("double", 7, "the end", "a name");
  expectError("double 3x", 8, "\"3x\"", "a name");
  expectError("double *x", 8, "\"*\"", "a name");
  expectError("double pad", 8, "\"pad\"", "a name");
  expectError("double x, ", 11, "the end", "a name");
  expectError("double x; float x", 17, "\"x\"", "a name that is not there yet");
  expectError("double x y", 10, "\"y\"", "\",\", \";\" or the end");
  expectError("double x[]", 10, "\"]\"", "a number in 1..");
  expectError("double x[0]", 10, "\"0\"", "a number in 1..");
  expectError("double x[-1]", 10, "\"-\"", "a number in 1..");
  expectError("double x[3.5]", 11, "\".\"", "\"]\"");
  expectError("double x[99999999999999999999]", 10, "\"99999999999999999999\"", "a number in 1..");
  expectError("double x[2", 11, "the end", "\"]\"");
  expectError("double x[2][2]", 12, "\"[\"", "\",\", \";\" or the end");
  expectError("pad x", 5, "\"x\"", "\"[\" and a number of bytes");
  expectError("double a[1000000000], b", 21, "\",\"", "at most 1073741824 bytes in all");
}

} // namespace
