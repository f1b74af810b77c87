// The layout is told in the header. It was read off p4est_save_ext, p4est_source_ext and
// p4est_connectivity_sink of p4est 0.3.5, 2.2 and 2.8.
#include "Forest/P4estForestFile.h"

#include "Forest/P4estInputFile.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>
#include <string_view>
#include <type_traits>

namespace treeamr
{
namespace
{

constexpr std::array<std::uint64_t, 2> formatCodes = { 0x2000009, 0x3000009 }; // of 2 and 3 dimensions
constexpr std::array<char, 8> magic3D = { 'p', '8', 'e', 's', 't' };
constexpr std::array<char, 8> magic2D = { 'p', '4', 'e', 's', 't' };
constexpr std::uint64_t headerOffset = 32; // behind the magic and the version's text, which decides nothing
constexpr std::uint64_t sectionAlignment = 32;
constexpr int oldRootBits = 19; // P8EST_MAXLEVEL up to p4est 2.2
constexpr int newRootBits = P4estForestFile::maxLevel + 1;

constexpr std::uint64_t alignUp(std::uint64_t offset)
{
  return (offset + sectionAlignment - 1) / sectionAlignment * sectionAlignment;
}

std::uint64_t byteSwapped(std::uint64_t value)
{
  auto bytes = std::bit_cast<std::array<std::byte, 8>>(value);
  std::ranges::reverse(bytes);
  return std::bit_cast<std::uint64_t>(bytes);
}

/// The ten numbers of the connectivity's header.
struct ConnectivityHeader
{
  std::uint64_t format;
  std::uint64_t indexSize;
  std::uint64_t vertices;
  std::uint64_t trees;
  std::uint64_t edges;
  std::uint64_t edgeEntries;
  std::uint64_t corners;
  std::uint64_t cornerEntries;
  std::uint64_t attributeBytes;
  std::uint64_t reserved;
};
static_assert(sizeof(ConnectivityHeader) == 80 && std::is_trivially_copyable_v<ConnectivityHeader>);

/// The six numbers that open the forest's header.
struct ForestHeader
{
  std::uint64_t format;
  std::uint64_t coordinateSize;
  std::uint64_t quadrantSize;
  std::uint64_t payloadSize;
  std::uint64_t hasPayload;
  std::uint64_t ranks;
};
static_assert(sizeof(ForestHeader) == 48 && std::is_trivially_copyable_v<ForestHeader>);

void checkFormat(const P4estInputFile& file, std::string_view section, std::uint64_t format, int dimension)
{
  const std::uint64_t formatCode = formatCodes[dimension - 2];
  if (format == byteSwapped(formatCode))
  {
    file.fail(section, ": saved on a machine of the other byte order, allowed the byte order of this one");
  }
  if (format != formatCode)
  {
    file.fail(section, std::hex, ": format 0x", format, ", allowed 0x", formatCode,
      " (p4est_save and p8est_save of p4est 0.3.5 and later)");
  }
}

/// The forest's dimension.
int readMagic(P4estInputFile& file)
{
  std::array<char, 8> magic{};
  file.read(magic.data(), std::min<std::uint64_t>(magic.size(), file.size()), "magic");
  if (magic == magic3D || magic == magic2D)
  {
    return magic == magic3D ? 3 : 2;
  }
  std::ostringstream found;
  for (const char c : std::string_view(magic.data(), std::min<std::uint64_t>(magic.size(), file.size())))
  {
    if (c >= ' ' && c <= '~')
    {
      found << c;
    }
    else
    {
      found << "\\x" << std::hex << (c >> 4 & 15) << (c & 15);
    }
  }
  file.fail(
    "begins with \"", found.str(), "\", allowed \"p8est\\x00\\x00\\x00\" (a forest saved by p8est_save)");
}

ConnectivityHeader readConnectivityHeader(P4estInputFile& file, int dimension)
{
  constexpr std::uint64_t headerEnd = headerOffset + sizeof(ConnectivityHeader);
  if (file.size() < headerEnd)
  {
    file.fail(
      "connectivity header: the file ends after ", file.size(), " bytes, allowed at least ", headerEnd);
  }
  file.seek(headerOffset);
  ConnectivityHeader header;
  file.read(&header, sizeof(header), "connectivity header");
  checkFormat(file, "connectivity header", header.format, dimension);
  if (header.indexSize != sizeof(std::int32_t))
  {
    file.fail("connectivity header: size of an index ", header.indexSize, ", allowed 4");
  }
  const auto checkCount = [&](std::string_view what, std::uint64_t found, std::uint64_t min,
                            bool mustBeZero = false) {
    const int ofBoxes = dimension == 2 ? 1 : 0; // twice as many
    const std::uint64_t max = mustBeZero ? 0 : std::numeric_limits<std::int32_t>::max() >> ofBoxes;
    if (found < min || found > max)
    {
      file.fail("connectivity header: ", found, ' ', what, ", allowed ", min, "..", max);
    }
  };
  checkCount("vertices", header.vertices, 0);
  checkCount("trees", header.trees, 1);
  checkCount("edges", header.edges, 0, dimension == 2);
  checkCount("edge entries", header.edgeEntries, 0, header.edges == 0);
  checkCount("corners", header.corners, 0);
  checkCount("corner entries", header.cornerEntries, 0, header.corners == 0);

  // No overflow: counts are below 2^31, so all but the attributes stay below 2^40.
  const std::uint64_t tableBytes =
    (4 << dimension) * header.trees; // of an index for each of a tree's corners
  const std::uint64_t bytes = 24 * header.vertices + (header.edges > 0 ? 48 * header.trees : 0) +
    (header.vertices > 0 ? tableBytes : 0) + (header.corners > 0 ? tableBytes : 0) +
    5 * 2 * dimension * header.trees + (dimension == 3 ? 4 * (header.edges + 1) : 0) +
    5 * header.edgeEntries + 4 * (header.corners + 1) + 5 * header.cornerEntries;
  const std::uint64_t left = file.size() - headerEnd;
  if (bytes > left || header.attributeBytes > (left - bytes) / header.trees)
  {
    file.fail("connectivity: ", header.trees, " trees, ", header.vertices, " vertices, ", header.edgeEntries,
      " edge entries, ", header.cornerEntries, " corner entries and ", header.attributeBytes,
      " attribute bytes per tree do not fit the file's ", file.size(), " bytes");
  }
  return header;
}

/// Makes the trees of a plane boxes over it.
void addThirdAxis(P4estConnectivity& connectivity, std::uint64_t corners)
{
  const std::size_t vertices = connectivity.vertices.size();
  for (std::size_t v = 0; v < vertices; ++v)
  {
    const auto [x, y, z] = connectivity.vertices[v];
    connectivity.vertices.push_back({ x, y, z + std::max(1., std::abs(z)) });
  }
  for (std::array<std::int32_t, 8>& ofTree : connectivity.treeVertices)
  {
    for (int c = 0; c < 4; ++c)
    {
      ofTree[c + 4] = ofTree[c] + static_cast<std::int32_t>(vertices);
    }
  }
  for (std::array<std::int32_t, 8>& ofTree : connectivity.treeCorners)
  {
    for (int c = 0; c < 4; ++c)
    {
      ofTree[c + 4] = ofTree[c] < 0 ? -1 : ofTree[c] + static_cast<std::int32_t>(corners);
    }
  }
  for (std::size_t tree = 0; tree < connectivity.neighbours.size(); ++tree)
  {
    for (const std::int8_t face : { 4, 5 })
    {
      connectivity.neighbours[tree][face] = { static_cast<std::int32_t>(tree), face, 0 };
    }
  }
}

/// tree_to_tree and tree_to_face, which are kept where there are no vertices.
void readNeighbours(
  P4estInputFile& file, const ConnectivityHeader& header, int dimension, P4estConnectivity& connectivity)
{
  const auto trees = static_cast<std::int64_t>(header.trees);
  const int faces = 2 * dimension;
  const int orientations = 1 << (dimension - 1);
  const bool isKept = header.vertices == 0;
  connectivity.neighbours.resize(isKept ? header.trees : 0);
  const auto neighbour = [&](std::uint64_t i) -> P4estConnectivity::Neighbour& {
    return connectivity.neighbours[i / static_cast<unsigned>(faces)][i % static_cast<unsigned>(faces)];
  };
  const std::uint64_t count = static_cast<std::uint64_t>(faces) * header.trees;
  file.checkTable<std::int32_t>(count, 0, trees, "tree_to_tree", [&](std::uint64_t i, std::int32_t tree) {
    if (isKept)
    {
      neighbour(i).tree = tree;
    }
  });
  file.checkTable<std::int8_t>(
    count, 0, faces * orientations, "tree_to_face", [&](std::uint64_t i, std::int8_t face) {
      if (isKept)
      {
        neighbour(i).face = static_cast<std::int8_t>(face % faces);
        neighbour(i).orientation = static_cast<std::int8_t>(face / faces);
      }
    });
}

P4estConnectivity readConnectivity(P4estInputFile& file, const ConnectivityHeader& header, int dimension)
{
  const std::uint64_t children = std::uint64_t(1) << dimension;
  const auto trees = static_cast<std::int64_t>(header.trees);
  const auto vertices = static_cast<std::int64_t>(header.vertices);
  const auto edges = static_cast<std::int64_t>(header.edges);
  const auto corners = static_cast<std::int64_t>(header.corners);

  P4estConnectivity connectivity;
  connectivity.vertices.resize(header.vertices);
  file.read(connectivity.vertices.data(), 24 * header.vertices, "connectivity, vertices");
  if (edges > 0)
  {
    file.checkTable<std::int32_t>(12 * header.trees, -1, edges, "tree_to_edge");
  }
  if (vertices > 0)
  {
    connectivity.treeVertices.resize(header.trees);
    file.readEach<std::int32_t>(
      children * header.trees, "tree_to_vertex", [&](std::uint64_t i, std::int32_t vertex) {
        if (vertex < 0 || vertex >= vertices)
        {
          file.fail("connectivity, tree ", i / children, ", corner ", i % children, ": vertex ", vertex,
            ", allowed 0..", vertices - 1);
        }
        connectivity.treeVertices[i / children][i % children] = vertex;
      });
  }
  if (corners > 0)
  {
    connectivity.treeCorners.resize(vertices > 0 ? 0 : header.trees);
    file.checkTable<std::int32_t>(
      children * header.trees, -1, corners, "tree_to_corner", [&](std::uint64_t i, std::int32_t corner) {
        if (vertices == 0)
        {
          connectivity.treeCorners[i / children][i % children] = corner;
        }
      });
  }
  readNeighbours(file, header, dimension, connectivity);
  file.seek(file.position() + header.trees * header.attributeBytes);
  if (dimension == 3)
  {
    file.checkOffsets(header.edges, header.edgeEntries, "ett_offset");
  }
  if (edges > 0)
  {
    file.checkTable<std::int32_t>(header.edgeEntries, 0, trees, "edge_to_tree");
    file.checkTable<std::int8_t>(header.edgeEntries, 0, 24, "edge_to_edge"); // 12 edges in 2 orientations
  }
  file.checkOffsets(header.corners, header.cornerEntries, "ctt_offset");
  if (corners > 0)
  {
    file.checkTable<std::int32_t>(header.cornerEntries, 0, trees, "corner_to_tree");
    file.checkTable<std::int8_t>(header.cornerEntries, 0, static_cast<int>(children), "corner_to_corner");
  }
  if (dimension == 2)
  {
    addThirdAxis(connectivity, header.corners);
  }
  return connectivity;
}

ForestHeader readForestHeader(P4estInputFile& file, std::uint64_t trees, int dimension)
{
  if (file.position() == file.size())
  {
    file.fail(
      "a connectivity only (p4est_connectivity_save, p8est_connectivity_save), allowed a forest saved by "
      "p4est_save or p8est_save");
  }
  const std::uint64_t begin = alignUp(file.position());
  if (file.size() < begin + sizeof(ForestHeader))
  {
    file.fail("forest header: the file ends after ", file.size(), " bytes, allowed at least ",
      begin + sizeof(ForestHeader));
  }
  file.seek(begin);
  ForestHeader header;
  file.read(&header, sizeof(header), "forest header");
  checkFormat(file, "forest header", header.format, dimension);
  if (header.coordinateSize != sizeof(std::int32_t))
  {
    file.fail("forest header: size of a coordinate ", header.coordinateSize, ", allowed 4");
  }
  if (header.quadrantSize != 24 && header.quadrantSize != 20) // with pointers of 8 or 4 bytes
  {
    file.fail("forest header: size of a quadrant ", header.quadrantSize, ", allowed 24 or 20");
  }
  if (header.hasPayload != (header.payloadSize > 0 ? 1 : 0))
  {
    file.fail("forest header: payload flag ", header.hasPayload, " with ", header.payloadSize,
      " bytes per quadrant, allowed 1 with a payload, 0 without");
  }
  const std::uint64_t left = (file.size() - file.position()) / 8;
  if (header.ranks == 0 || header.ranks > left || trees > left - header.ranks)
  {
    file.fail("forest header: counts of ", header.ranks, " ranks and ", trees,
      " trees, allowed at least 1 rank and ", left, " counts before the end of the file");
  }
  return header;
}

/// Quadrants up to the end of each tree. Refining makes eight cells of one, hence 1 + 7 n of them in a tree, or four, 1 + 3 n.
std::vector<std::uint64_t> readTreeEnds(
  P4estInputFile& file, std::uint64_t ranks, std::uint64_t trees, int dimension)
{
  const std::uint64_t more = (std::uint64_t(1) << dimension) - 1;
  std::uint64_t previous = 0;
  file.readEach<std::uint64_t>(ranks, "partition", [&](std::uint64_t rank, std::uint64_t end) {
    if (end < previous)
    {
      file.fail("partition, rank ", rank, ": ends at quadrant ", end, ", allowed at least ", previous);
    }
    previous = end;
  });
  const std::uint64_t total = previous;

  std::vector<std::uint64_t> ends(trees);
  previous = 0;
  file.readEach<std::uint64_t>(trees, "tree ends", [&](std::uint64_t tree, std::uint64_t end) {
    if (end <= previous || end > total || (tree + 1 == trees && end != total))
    {
      file.fail("tree ", tree, ": ends at quadrant ", end, ", allowed ",
        tree + 1 == trees ? total : previous + 1, "..", total);
    }
    if ((end - previous) % more != 1)
    {
      file.fail("tree ", tree, ": ", end - previous, " quadrants, allowed 1 and a multiple of ", more);
    }
    ends[tree] = previous = end;
  });
  return ends;
}

struct Record
{
  std::array<std::int32_t, 3> anchor{}; // of two dimensions: z is 0
  std::int32_t level = 0;

  static std::size_t bytes(int dimension) { return 4 * (static_cast<std::size_t>(dimension) + 1); }
  static Record from(const std::byte* bytes, int dimension)
  {
    Record record;
    std::memcpy(record.anchor.data(), bytes, 4 * static_cast<std::size_t>(dimension));
    std::memcpy(&record.level, bytes + 4 * static_cast<std::size_t>(dimension), 4);
    return record;
  }
};

std::ostream& operator<<(std::ostream& out, const Record& record)
{
  return out << '(' << record.anchor[0] << ", " << record.anchor[1] << ", " << record.anchor[2]
             << ") of level " << record.level;
}

/// The first quadrant of a refined tree sits at the origin and its neighbour begins where it ends in x.
int findRootBits(P4estInputFile& file, std::uint64_t quadrantsOffset, std::size_t recordBytes,
  const std::vector<std::uint64_t>& treeEnds, int dimension)
{
  if (dimension == 2)
  {
    return newRootBits; // of all versions
  }
  std::uint64_t begin = 0;
  for (std::size_t tree = 0; tree < treeEnds.size(); begin = treeEnds[tree++])
  {
    if (treeEnds[tree] - begin == 1)
    {
      continue;
    }
    std::array<Record, 2> records;
    for (int i = 0; i < 2; ++i)
    {
      file.seek(quadrantsOffset + (begin + i) * recordBytes);
      std::array<std::byte, 16> bytes;
      file.read(bytes.data(), bytes.size(), "quadrants");
      records[i] = Record::from(bytes.data(), dimension);
    }
    for (const int bits : { oldRootBits, newRootBits })
    {
      const int level = records[0].level;
      if (level > 0 && level < bits && records[1].anchor[0] == std::int32_t(1) << (bits - level))
      {
        return bits;
      }
    }
    file.fail("tree ", tree, ": quadrant 0 at ", records[0], ", quadrant 1 at ", records[1],
      ", allowed neighbours along x in a tree 2^", oldRootBits, " or 2^", newRootBits, " wide");
  }
  return newRootBits;
}

/// Walks a tree's quadrants in Morton order: each must begin where the one before ended.
class MortonWalk
{
public:
  MortonWalk(int rootBits, int dimension)
    : rootBits_(rootBits)
    , dimension_(dimension)
  {
  }
  bool isComplete() const { return complete_; }

  /// To behind a quadrant that is where another walk found it right.
  void start(const P4estInputFile& file, const Record& record, std::int32_t tree, std::uint64_t quadrant)
  {
    anchor_ = record.anchor;
    advance(file, record, tree, quadrant);
  }

  /// Throws when the quadrant does not begin where the walk is, or does not fit there.
  void advance(const P4estInputFile& file, const Record& record, std::int32_t tree, std::uint64_t quadrant)
  {
    if (record.level < 0 || record.level >= rootBits_)
    {
      file.fail(
        "tree ", tree, ", quadrant ", quadrant, ": level ", record.level, ", allowed 0..", rootBits_ - 1);
    }
    if (complete_)
    {
      file.fail("tree ", tree, ", quadrant ", quadrant, ": at ", record, ", allowed none: the tree is full");
    }
    if (record.anchor != anchor_)
    {
      file.fail("tree ", tree, ", quadrant ", quadrant, ": at ", record, ", allowed (", anchor_[0], ", ",
        anchor_[1], ", ", anchor_[2], "): Morton order without gaps");
    }
    int bit = rootBits_ - record.level;
    const int trailingZeros =
      std::countr_zero(static_cast<std::uint32_t>(anchor_[0] | anchor_[1] | anchor_[2]));
    if (bit > trailingZeros)
    {
      file.fail("tree ", tree, ", quadrant ", quadrant, ": level ", record.level, " at (", anchor_[0], ", ",
        anchor_[1], ", ", anchor_[2], "), allowed ", rootBits_ - trailingZeros, "..", rootBits_ - 1);
    }
    // The next octant of the parent, or of the first ancestor that is not finished.
    for (; bit < rootBits_; ++bit)
    {
      const std::int32_t side = std::int32_t(1) << bit;
      for (int a = 0; a < dimension_; ++a)
      {
        anchor_[a] ^= side;
        if (anchor_[a] & side)
        {
          return;
        }
      }
    }
    complete_ = true;
  }

private:
  int rootBits_;
  int dimension_;
  bool complete_ = false;
  std::array<std::int32_t, 3> anchor_{};
};

} // namespace

P4estForestFile::P4estForestFile(std::string path)
  : path_(std::move(path))
{
  P4estInputFile file(path_);
  dimension_ = readMagic(file);
  const ConnectivityHeader connectivityHeader = readConnectivityHeader(file, dimension_);
  connectivity_ = readConnectivity(file, connectivityHeader, dimension_);
  const ForestHeader forestHeader = readForestHeader(file, connectivityHeader.trees, dimension_);
  treeEnds_ = readTreeEnds(file, forestHeader.ranks, connectivityHeader.trees, dimension_);

  quadrantsOffset_ = alignUp(file.position());
  const std::uint64_t left = file.size() - std::min(quadrantsOffset_, file.size());
  const std::size_t recordBytes = Record::bytes(dimension_);
  if (forestHeader.payloadSize > left || quadrantCount() > left / (recordBytes + forestHeader.payloadSize))
  {
    file.fail("quadrants: ", quadrantCount(), " of ", recordBytes, " + ", forestHeader.payloadSize,
      " bytes, allowed what fits ", left, " bytes before the end of the file");
  }
  payloadSize_ = forestHeader.payloadSize;
  rootBits_ = findRootBits(file, quadrantsOffset_, recordBytes + payloadSize_, treeEnds_, dimension_);
}

bool P4estForestFile::hasMagic(const std::string& path) noexcept
{
  try
  {
    std::array<char, 8> magic{};
    std::ifstream stream(path, std::ios::binary);
    return stream.read(magic.data(), magic.size()) && (magic == magic3D || magic == magic2D);
  }
  catch (const std::exception&)
  {
    return false;
  }
}

void P4estForestFile::readQuadrants(std::span<const LeafRange> ranges, LeafBlock& block) const
{
  const std::size_t recordBytes = Record::bytes(dimension_) + payloadSize_;
  std::uint64_t count = 0;
  for (const LeafRange& range : ranges)
  {
    count += range.count();
  }
  block.bytes.resize((count + ranges.size()) * recordBytes); // of each range the one before, too
  block.leaves.clear();
  block.leaves.reserve(count);
  P4estInputFile file(path_);
  std::byte* bytes = block.bytes.data();
  for (const LeafRange& range : ranges)
  {
    appendQuadrants(file, range, bytes, block);
    bytes += (range.count() + 1) * recordBytes;
  }
}

/// bytes: for those of all and of the one before.
void P4estForestFile::appendQuadrants(
  P4estInputFile& file, const LeafRange& range, std::byte* bytes, LeafBlock& block) const
{
  const std::size_t placeBytes = Record::bytes(dimension_);
  const std::size_t recordBytes = placeBytes + payloadSize_;
  auto tree = static_cast<std::int32_t>(
    std::upper_bound(treeEnds_.begin(), treeEnds_.end(), range.begin) - treeEnds_.begin());
  std::uint64_t treeBegin = treeEnds_[tree] - quadrantCount(tree);
  const bool isAmidTree = range.begin > treeBegin; // the one before says where the first one has to be

  const std::uint64_t first = range.begin - (isAmidTree ? 1 : 0);
  file.seek(quadrantsOffset_ + first * recordBytes);
  file.read(bytes, (range.end - first) * recordBytes, "quadrants");
  const std::byte* next = bytes;

  MortonWalk walk(rootBits_, dimension_);
  if (isAmidTree)
  {
    walk.start(file, Record::from(next, dimension_), tree, first - treeBegin);
    next += recordBytes;
  }
  for (std::uint64_t quadrant = range.begin; quadrant < range.end; ++quadrant, next += recordBytes)
  {
    if (quadrant == treeEnds_[tree])
    {
      treeBegin = treeEnds_[tree++];
      walk = MortonWalk(rootBits_, dimension_);
    }
    const Record record = Record::from(next, dimension_);
    walk.advance(file, record, tree, quadrant - treeBegin);
    TreeLeaf& leaf =
      block.leaves.emplace_back(TreeLeaf{ tree, {}, record.level, quadrant, next + placeBytes });
    for (int a = 0; a < 3; ++a)
    {
      leaf.index[a] = static_cast<std::uint32_t>(record.anchor[a]) >> (rootBits_ - record.level);
    }
    if (quadrant + 1 == treeEnds_[tree] && !walk.isComplete())
    {
      file.fail("tree ", tree, ": its ", quadrantCount(tree), " quadrants end before the tree is full");
    }
  }
}

std::uint64_t P4estForestFile::blockQuadrants() const noexcept
{
  return std::max<std::uint64_t>(
    1, P4estInputFile::blockBytes / 2 / (sizeof(TreeLeaf) + Record::bytes(dimension_) + payloadSize_));
}

void P4estForestFile::visitQuadrants(const std::function<void(const TreeLeaf&)>& visit) const
{
  const std::uint64_t blockCount =
    std::min<std::uint64_t>(1024, blockQuadrants()); // of a file's size of memory
  LeafBlock block;
  for (std::uint64_t begin = 0; begin < quadrantCount(); begin += block.leaves.size())
  {
    const LeafRange range{ begin, std::min(quadrantCount(), begin + blockCount) };
    readQuadrants({ &range, 1 }, block);
    for (const TreeLeaf& leaf : block.leaves)
    {
      visit(leaf);
    }
  }
}

void P4estForestFile::readAnchors(
  P4estInputFile& file, std::uint64_t first, std::span<std::array<std::int32_t, 3>> anchors) const
{
  const std::size_t recordBytes = Record::bytes(dimension_) + payloadSize_;
  std::vector<std::byte> bytes(anchors.size() * recordBytes);
  file.seek(quadrantsOffset_ + first * recordBytes);
  file.read(bytes.data(), bytes.size(), "quadrants");
  for (std::size_t i = 0; i < anchors.size(); ++i)
  {
    anchors[i] = Record::from(bytes.data() + i * recordBytes, dimension_).anchor;
  }
}

void P4estForestFile::samplePayloads(
  std::uint64_t count, const std::function<void(const std::byte*)>& visit) const
{
  const std::size_t placeBytes = Record::bytes(dimension_);
  P4estInputFile(path_).sampleRecords(quadrantsOffset_, placeBytes + payloadSize_, quadrantCount(), count,
    "quadrants", [&](const std::byte* record) { visit(record + placeBytes); });
}

} // namespace treeamr
