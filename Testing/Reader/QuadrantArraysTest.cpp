// Arrays in files beside a forest: texts, numpy's files as it writes them, raw ones, and what is none of these.
#include "Forest/QuadrantArrays.h"

#include "Error.h"
#include "Support/ForestBytes.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <functional>

using namespace treeamr;
using namespace treeamr::test;

namespace
{

void expectError(const std::function<void()>& act, const std::string& part)
{
  try
  {
    act();
    ADD_FAILURE() << "no error, should say " << part;
  }
  catch (const Error& error)
  {
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos)
      << error.what() << "\nshould say " << part;
  }
}

class QuadrantArraysTest : public ::testing::Test
{
protected:
  QuadrantArrayFile open(const std::string& text, std::uint64_t quadrants)
  {
    return { parseQuadrantArrays(text).at(0), folder_.file("out_0007.p8est"), quadrants };
  }

  /// As numpy.save() lays it out: the header's size makes the values begin at a multiple of 64.
  template <class T>
  void saveNumpy(
    const std::string& name, const std::string& dictionary, const std::vector<T>& values, char version = 1)
  {
    const std::size_t prefix = version == 1 ? 10 : 12;
    std::string header = dictionary;
    header.resize((prefix + dictionary.size() + 1 + 63) / 64 * 64 - prefix, ' ');
    header.back() = '\n';
    std::ofstream file(folder_.file(name), std::ios::binary);
    file.write("\x93NUMPY", 6).put(version).put(0);
    for (std::size_t i = 0; i < prefix - 8; ++i)
    {
      file.put(static_cast<char>(header.size() >> (8 * i) & 255));
    }
    file << header;
    file.write(
      reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(T)));
  }

  TemporaryFolder folder_;
};

template <class T>
T valueAt(const QuadrantArrayFile& file, std::uint64_t quadrant, std::size_t component = 0)
{
  T value{};
  file.records().visit(quadrant, 1,
    [&](const std::byte* values) { std::memcpy(&value, values + component * sizeof(T), sizeof(T)); });
  return value;
}

TEST_F(QuadrantArraysTest, Texts)
{
  const auto arrays =
    parseQuadrantArrays(" density.npy ;u=sub/velocity.npy; unsigned long  id[2] = {}_id.raw ;; ");
  ASSERT_EQ(arrays.size(), 3u);
  EXPECT_EQ(arrays[0].field.name, "density");
  EXPECT_TRUE(arrays[0].isNumpy);
  EXPECT_EQ(arrays[1].field.name, "u");
  EXPECT_EQ(arrays[1].path, "sub/velocity.npy");
  EXPECT_EQ(arrays[2].field.name, "id");
  EXPECT_EQ(arrays[2].field.type, PayloadType::UInt64);
  EXPECT_EQ(arrays[2].field.components, 2);
  EXPECT_FALSE(arrays[2].isNumpy);
  EXPECT_TRUE(parseQuadrantArrays(" ; ").empty());

  expectError([] { parseQuadrantArrays("a.npy; p.raw"); }, "\"p.raw\": a file that does not say its type");
  expectError([] { parseQuadrantArrays("double a.npy = a.npy"); }, "a name alone");
  expectError([] { parseQuadrantArrays("a ="); }, "no file");
  expectError([] { parseQuadrantArrays("duble a = a.raw"); }, "allowed pad[n] or a type");
  expectError([] { parseQuadrantArrays("double a, b = a.raw"); }, "2 arrays in one file");
  expectError([] { parseQuadrantArrays("a.npy; float a = b.raw"); }, "a name that is there already");
}

TEST_F(QuadrantArraysTest, FilesOfNumpy)
{
  std::vector<double> doubles(300000);
  for (std::size_t i = 0; i < doubles.size(); ++i)
  {
    doubles[i] = 0.5 * static_cast<double>(i);
  }
  saveNumpy("a.npy", "{'descr': '<f8', 'fortran_order': False, 'shape': (300000,), }", doubles);
  QuadrantArrayFile all = open("a.npy", doubles.size());
  EXPECT_EQ(all.field().type, PayloadType::Float64);
  EXPECT_EQ(all.field().components, 1);
  std::size_t next = 100;
  all.records().visit(next, doubles.size() - 100, [&](const std::byte* values) { // of several blocks
    ASSERT_EQ(std::memcmp(values, &doubles[next++], sizeof(double)), 0);
  });
  EXPECT_EQ(next, doubles.size());
  EXPECT_EQ(valueAt<double>(all, 5), 2.5);

  saveNumpy("b.npy", "{'descr': '<f8', 'fortran_order': False, 'shape': (100000, 3), }", doubles, 2);
  QuadrantArrayFile triples = open("velocity = b.npy", 100000);
  EXPECT_EQ(triples.field().name, "velocity");
  EXPECT_EQ(triples.field().components, 3);
  EXPECT_EQ(valueAt<double>(triples, 99999, 2), doubles.back());

  saveNumpy<signed char>("c.npy", "{'descr': '|i1', 'fortran_order': False, 'shape': (2,), }", { -3, 7 }, 3);
  QuadrantArrayFile bytes = open("c.npy", 2);
  EXPECT_EQ(bytes.field().type, PayloadType::Int8);
  EXPECT_EQ(valueAt<signed char>(bytes, 0), -3);
}

TEST_F(QuadrantArraysTest, RawFilesOfSeries)
{
  const std::vector<float> values{ 1.f, 2.f, 3.f, 4.f };
  std::ofstream(folder_.file("out_0007_b.raw"), std::ios::binary)
    .write(reinterpret_cast<const char*>(values.data()), 16);
  QuadrantArrayFile file = open("float b[2] = {}_b.raw", 2);
  EXPECT_EQ(valueAt<float>(file, 1, 1), 4.f);
  expectError([&] { open("float b = {}_b.raw", 3); }, "16 bytes of values, 4 each, allowed 3");
  expectError([&] { open("float b[3] = {}_b.raw", 1); }, "16 bytes of values, 12 each, allowed 1");
}

TEST_F(QuadrantArraysTest, FilesThatAreNone)
{
  expectError([&] { open("nothing.npy", 1); }, "nothing.npy: no such file");
  const auto spoilt = [&](const std::string& bytes, const std::string& part) {
    std::ofstream(folder_.file("x.npy"), std::ios::binary) << bytes;
    expectError([&] { open("x.npy", 1); }, part);
  };
  spoilt("", "no magic string");
  spoilt("\x93NUMP", "no magic string");
  spoilt(std::string("\x93NUMPY\x07\0\x10\0", 10), "format version 7");
  spoilt(std::string("\x93NUMPY\x01\0\xff\xff{}", 12), "a header of 65535 bytes");
  spoilt(std::string("\x93NUMPY\x03\0\xff\xff\xff\xff{}", 14), "a header of 4294967295 bytes");
  const auto header = [&](const std::string& dictionary, const std::string& part) {
    saveNumpy<double>("x.npy", dictionary, { 1., 2. });
    expectError([&] { open("x.npy", 2); }, part);
  };
  header("{}", "no descr in its header");
  header("{'descr': '>f8', 'fortran_order': False, 'shape': (2,), }", "type >f8");
  header("{'descr': '<c16', 'fortran_order': False, 'shape': (1,), }", "type <c16");
  header("{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (2,), }", "type [");
  header("{'descr': '<f8', 'fortran_order': False, 'shape': (3,), }", "shape (3), allowed a first axis of 2");
  header("{'descr': '<f8', 'fortran_order': False, 'shape': (), }", "shape ()");
  header("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 0), }", "shape (2, 0)");
  header("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 1, 1), }", "shape (2, 1, 1)");
  header("{'descr': '<f8', 'fortran_order': False, 'shape': (-2,), }", "allowed whole numbers");
  header("{'descr': '<f8', 'fortran_order': False, 'shape': 2", "no shape");
  header("{'descr': '<f4', 'fortran_order': True, 'shape': (2, 2), }", "Fortran order");
  header("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 4), }", "16 bytes of values, 32 each");
}

} // namespace
